"""Services: copies, later turns, no answer, queues that keep the last."""

from __future__ import annotations

from typing import Any

from std_srvs.srv import SetBool, Trigger

from tests.support.ros import Ros
from tests.support.waiting import wait_until


def test_a_call_is_answered(ros: Ros) -> None:
    def answer(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success, response.message = request.data, "done"
        return response

    server = ros.spun("server")
    server.create_service(SetBool, "set", answer)
    client = ros.spun("client").create_client(SetBool, "set")
    assert client.wait_for_service(10.0)
    response = ros.result(client.call_async(SetBool.Request(data=True)))
    assert (response.success, response.message) == (True, "done")
    assert client.call(SetBool.Request(data=False)).success is False


def test_an_async_callback_is_awaited(ros: Ros) -> None:
    server = ros.spun("server")
    other = server.create_client(Trigger, "inner")

    async def outer(request: Any, response: Any) -> Any:
        response.message = "outer"
        return response

    server.create_service(Trigger, "outer", outer)
    client = ros.spun("client").create_client(Trigger, "outer")
    assert client.wait_for_service(10.0)
    assert not other.service_is_ready()
    assert ros.result(client.call_async(Trigger.Request())).message == "outer"


def test_a_call_that_nobody_serves_stays_pending(ros: Ros) -> None:
    client = ros.spun().create_client(Trigger, "nobody")
    assert not client.wait_for_service(0.05)
    assert not client.service_is_ready()
    future = client.call_async(Trigger.Request())
    assert not future.done()
    client.remove_pending_request(future)


def test_an_unspun_service_keeps_the_last_ten_requests(ros: Ros) -> None:
    server = ros.node("server")
    served: list[bool] = []

    def answer(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        served.append(request.data)
        return response

    server.create_service(SetBool, "set", answer)
    client = ros.spun("client").create_client(SetBool, "set")
    assert client.wait_for_service(10.0)
    futures = [client.call_async(SetBool.Request(data=number >= 5)) for number in range(15)]
    ros.spin(server)
    wait_until(lambda: futures[-1].done())
    assert served == [True] * 10
    assert sum(future.done() for future in futures) == 10


def test_a_service_comes_and_goes(ros: Ros) -> None:
    server = ros.spun("server")
    service = server.create_service(Trigger, "trigger", lambda request, response: response)
    client = ros.spun("client").create_client(Trigger, "trigger")
    assert client.wait_for_service(10.0)
    executor = server.executor
    assert executor is not None
    executor.create_task(server.destroy_service, service)  # on the thread that spins it
    wait_until(lambda: not client.service_is_ready())
