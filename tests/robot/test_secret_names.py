"""Secret parameters: which names are, and who does not get to see the values."""

from __future__ import annotations

import json
from typing import Any

import pytest
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rosbags.highlevel import AnyReader

from archo_tui.base.paths import journal_file, state_file
from archo_tui.recordings import recorder, store
from archo_tui.robot.graph.parameter_values import is_secret
from tests.support.shells import heard, raw, served, typed

SECRET = [
    *("password", "Password", "wifi.password", "WIFI_PASSWORD_2", "auth_tokens", "token_file"),
    *("key", "api_key", "apiKey", "APIKey", "key2", "api_key.value", "client-secret", "keys"),
    *("dbpassword", "WIFIPASSWORD", "authtokens", "clientsecret.value", "apikey", "mapsapikey"),
]
OPEN = [
    *("monkey", "key_bindings", "keyframe", "key_rate.hz", "turkey", "tokenizer", "secretary"),
    *("passwordless", "max_speed", ""),
]


@pytest.mark.pure
@pytest.mark.parametrize("name", SECRET)
def test_words_of_a_name_make_it_a_secret(name: str) -> None:
    assert is_secret(name)


@pytest.mark.pure
@pytest.mark.parametrize("name", OPEN)
def test_parts_of_words_do_not(name: str) -> None:
    assert not is_secret(name)


class Door(Node):
    """Has a secret, and refuses one by quoting it."""

    def __init__(self, **options: Any) -> None:
        super().__init__("door", **options)
        described = ParameterDescriptor(description="of the gate")
        self.declare_parameter("api_key", "hunter2", described)
        self.declare_parameter("pin_secret", 471135082)
        self.declare_parameter("key_bindings", "qwerty")
        self.add_on_set_parameters_callback(self.check)

    def check(self, parameters: list[Any]) -> SetParametersResult:
        bad = [one.value for one in parameters if one.value == "letmein"]
        return SetParametersResult(successful=not bad, reason=f"weak: {bad[0]}" if bad else "")


@pytest.mark.real_time
async def test_only_the_operator_sees_a_secret(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder, "SECONDS_AFTER", 0.2)
    async with served(Door) as person:
        person.type("set door api_key s3same\nset door pin_secret 843237972\n")
        person.type("set door key_bindings dvorak\n")
        await heard(person, "key_bindings is dvorak, was qwerty")
        assert "set door api_key ***: api_key is ***, was ***" in person.said
        person.type("set door api_key letmein\n")
        await heard(person, "weak: ***")
        client = await raw()
        await client.line()
        told = ""
        for number, words in enumerate((["params"], ["get", "door", "api_key"], ["events", "99"])):
            client.send({"id": number, "assistant": True, "words": words})
            told += json.dumps(await client.line())
        client.close()
        shown = await typed("get", "door", "api_key")
        assert "api_key is s3same, was hunter2 at the start" in shown.out  # the operator's own
        assert (await typed("keep")).code == 0
        await person.end()
    (recording,) = store.list_recordings(state_file("recordings"))
    with AnyReader([recording.folder]) as reader:
        recorded = b"".join(data for _, _, data in reader.messages()).decode(errors="replace")
    journal = journal_file().read_text()
    for secret in ("s3same", "hunter2", "letmein", "843237972", "471135082"):
        for where in (told, recorded, journal):
            assert secret not in where, secret
    for where in (told, recorded, journal):
        assert "dvorak" in where
