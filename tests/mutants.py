"""Deliberate faults, planted one by one into a copy of the project: does a test notice each?

    python -m tests.mutants [words of the faults to try]

Not run with the tests. Each fault names the tests that should notice it; they run until the first
one fails. Ends with exit code 1 when a fault was not noticed.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent


class Fault(NamedTuple):
    """One line of the product, and what it says instead."""

    file: str  # below archo_tui/, or from the root
    line: str
    instead: str
    tests: str


E = "embedded/rclpy/"
BRINGUP = "nodes/archo_bringup/"
CONSOLE, ROBOT, CONTRACT = "tests/console", "tests/robot", "tests/contract"
WHICH = "tests/remote/test_which_console.py"
PYTHON = "tests/remote/test_python.py"
LEARNERS = "tests/chapter/test_check.py"
FAULTS = [
    # what is said line by line
    Fault("plain/plain.py", "min(int(goal.fraction() * 4), 3)", "int(goal.fraction() * 100)", "tests/plain/test_plain_spoken.py"),
    Fault("plain/plain.py", "        return not (refusal and its)", "        return True", "tests/plain/test_plain_spoken.py"),
    Fault("words/spoken.py", "    if found.is_old(now):  # they would sound as if they were of now", "    if False:", "tests/plain/test_plain_spoken.py"),
    Fault("verbs/goals.py", "        if now is None or now.number != goal.number:", "        if False:", CONSOLE + "/test_others_goals.py"),
    Fault("station/alarms.py", "        elif health(snapshot) == \"replace\":", "        elif False:", "tests/station/test_alarms.py"),
    Fault("robot/stopping.py", "        elif self._is_latched and self._unheeded is None:", "        elif False:", ROBOT + "/test_stop_and_motion.py"),
    Fault("robot/stopping.py", "            self._unheeded = self.open.asked\n            self.over()\n            return True", "            self.over()\n            return True", ROBOT + "/test_stop_and_motion.py"),
    Fault("robot/client.py", "            if self._stopping.open is not None and not gate.is_shut:", "            if False:", ROBOT + "/test_stop_and_motion.py"),
    Fault("robot/stops.py", " or self.stops.elsewhere > self.told", "", "tests/plain/test_plain_stops.py"),
    Fault("plain/plain.py", "await self._until(lambda: stops.overtaken, rest)", "await self._clock.sleep(rest)", "tests/plain/test_plain_stops.py"),
    Fault("commands/robot.py", " and not stops.overtaken:", ":", CONSOLE + "/test_stop_seams.py"),
    Fault("station/station.py", "            self._elsewhere = self.robot.stops.elsewhere\n            self.ask_no_more()", "            pass", CONSOLE + "/test_stop_seams.py"),
    Fault("robot/followed.py", "            if self.is_taken:", "            if True:", "tests/robot/test_answered_late.py"),
    Fault("robot/goals.py", "one.is_unwanted or not one.is_taken", "one.is_unwanted", "tests/robot/test_answered_late.py"),
    Fault("station/undo.py", " | self._set_since(last, node, values)", "", "tests/parameters/test_undo.py"),
    Fault("remote/finder.py", "    if len(found) == 1 and not silent:", "    found = [one for one in found if not one.fault]\n    if len(found) == 1:", WHICH),
    Fault("remote/finder.py", "_exchange(found, first, is_over, SOON)", "_exchange(found, b'', lambda one: bool(one.hello), SOON)", WHICH),
    Fault("remote/server.py", "read, last = _read_at_once(connected), -_REST", "read, last = b'', -_REST", WHICH),
    Fault("remote/server.py", "            self._is_deaf = True\n        finally", "            self._socket.close()\n        finally", WHICH),
    Fault("remote/server.py", "        if request is not None and not is_meant(request, self._server.hello):", "        if False:", WHICH),
    Fault("remote/server.py", " | os.O_EXCL", "", WHICH),
    Fault("remote/server.py", "        _link(self._path)", "        pass", WHICH),
    Fault("remote/server.py", "for data in cutter.take(b\"\\n\"):", "for data in ():", WHICH),
    Fault("remote/place.py", "found.append(os.path.join(_RUNTIME", "(os.path.join(_RUNTIME", WHICH),
    Fault("remote/desk.py", "visit.is_waiting = visit.asker.has_left = True", "pass", PYTHON),
    Fault("assistant/server.py", "    server.middleware.append(_take_any_stop)", "    pass", "tests/remote/test_what_a_stop_is.py"),
    Fault("remote/desk.py", 'self.is_waiting = request.get("wait") is True', "self.is_waiting = False", PYTHON),
    Fault("remote/api.py", "        except BaseException:\n            self._request.give_up()\n", "        except BaseException:\n", PYTHON),
    Fault("remote/api.py", "        if error is not None:\n            self.give_up()\n        self.close()", "        pass", PYTHON),
    Fault("remote/api.py", "                self._check_that_it_answers()", "                pass", PYTHON),
    Fault("remote/finder.py", "_able_to_act(find(asked, faults))", "find(asked, faults)", WHICH),
    Fault("cli.py", "        if at is None:", "        if True:", "tests/remote/test_what_a_stop_is.py"),
    Fault("cli.py", "    typed = [*options.command, *options.behind]", "    typed = options.command", "tests/remote/test_what_a_stop_is.py"),
    Fault("remote/waits.py", "    return is_bad or _is_silent(station)", "    return is_bad", "tests/remote/test_waits.py"),
    Fault("terminal/paste.py", "not (self._once * len(burst)).startswith(burst)", "self._once != burst", "tests/terminal/test_paste.py"),
    Fault("station/journal.py", "return count <= _ALIKE or count % 1000 == 0", "return True", "tests/station/test_journal.py"),
    Fault(BRINGUP + "motion.py", "        return 1 if new > longest else max(new, 0)", "        return max(new, 0)", "tests/nodes"),
    Fault("hosting/host.py", "        while (threads := self.threads()) and time.monotonic() < end:\n            threads[0].join(", "        for thread in self.threads():\n            thread.join(", "tests/hosting/test_host.py"),
    Fault("robot/period.py", "        return Period(known=seconds)\n\n", "        return Period()\n\n", ROBOT + "/test_silence.py"),
    Fault("robot/period.py", "        if abs(seconds - old) <= _ALIKE * old and new > 0:", "        if False:", ROBOT + "/test_checks.py"),
    # seen to go unnoticed once
    Fault("robot/goals.py", "now - age if 0 <= age <= _LONGEST_AGE else now", "now - age", ROBOT + "/test_odd_robots.py"),
    Fault("robot/goals.py", "        self._refusals.clear()\n", "", ROBOT + "/test_odd_robots.py"),
    Fault("robot/parameters.py", "min(2 * waited, _LONGEST_RETRY)", "2 * waited", ROBOT + "/test_odd_robots.py"),
    Fault("robot/state.py", "took / driven - (now - self.heard)", "took / driven", ROBOT + "/test_odd_robots.py"),
    Fault("robot/telemetry.py", "DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE", "DurabilityPolicy.VOLATILE", ROBOT + "/test_odd_robots.py"),
    Fault("robot/stops.py", "return self.stops.is_void(self.typed)", "return False", "tests/plain/test_plain_stops.py tests/terminal/test_stop_is_final.py"),
    Fault("robot/client.py", "        if self._stopping.is_behind(turn):", "        if False:", ROBOT + "/test_stop_and_releases.py"),
    Fault("robot/stopping.py", "    if len(answers) < servers:\n", "    if not answers:\n", ROBOT + "/test_several_servers.py"),
    Fault("robot/services.py", "if len(answers) >= servers or good(answer):", "if True:", ROBOT + "/test_several_servers.py"),
    Fault("robot/services.py", "late(answers) if is_late else None", "None", ROBOT + "/test_several_servers.py"),
    Fault("robot/stopping.py", "if number < self._first:", "if False:", ROBOT + "/test_several_servers.py"),
    Fault("robot/followed.py", "ASK_AGAIN = 5.0", "ASK_AGAIN = 500.0", ROBOT + "/test_several_servers.py"),
    Fault("robot/goals.py", "            one.ask_result()\n        return Outcome(\n", "            pass\n        return Outcome(\n", ROBOT + "/test_several_servers.py"),
    Fault("robot/client.py", "if topic not in self._graph.publishers:", "if True:", ROBOT + "/test_odd_robots.py"),
    Fault("robot/others.py", "_LATE if act.code == Code.TIMEOUT else", "_PATIENCE if True else", ROBOT + "/test_odd_robots.py"),
    Fault("robot/others.py", "        if act.code not in _NOT_DONE:", "        if True:", ROBOT + "/test_odd_robots.py"),
    Fault("robot/others.py", "arguments.get(\"node\") == self.node and named", "named", ROBOT + "/test_odd_robots.py"),
    Fault("robot/others.py", "self._services.get(service, act.verb)", "act.verb", ROBOT + "/test_odd_robots.py"),
    Fault("robot/acts.py", "    if len(form) > LONGEST:", "    if False:", ROBOT + "/test_acts.py"),
    Fault("robot/acts.py", " and depth > _DEEPEST:", " and False:", ROBOT + "/test_acts.py"),
    Fault("robot/acts.py", "    if len(whole) <= LONGEST:", "    if True:", ROBOT + "/test_acts.py"),
    Fault("robot/client.py", " or told.console not in self._graph.consoles:", ":", CONSOLE + "/test_others_goals.py"),
    Fault("robot/client.py", "if who in self._graph.mute:", "if who in self._graph.consoles:", CONSOLE + "/test_others_goals.py"),
    Fault("robot/graph.py", "self.mute = frozenset(self.consoles)", "self.mute = frozenset()", CONSOLE + "/test_others_goals.py"),
    Fault("session.py", "            if event.act is not None:", "            if False:", "tests/station/test_journal.py"),
    Fault("robot/events.py", "event.act.bounded()", "event.act", ROBOT + "/test_acts.py"),
    Fault("robot/client.py", "Code.HELD if queued else Code.CANCELLED, NOT_SENT", "Code.CANCELLED, NOT_SENT", ROBOT + "/test_stop_and_goals.py"),
    Fault("robot/offers.py", 'if kinds[field] != "boolean":', "if False:", ROBOT + "/test_odd_robots.py"),
    Fault("robot/goals.py", "            if one.is_void:\n", "            if False:\n", ROBOT + "/test_stop_and_goals.py"),
    Fault("robot/stopping.py", "        if said.outcome.ok:\n            self._unheeded = self.open.asked\n            self.over()", "        if True:\n            self.over()", ROBOT + "/test_several_servers.py"),
    Fault("robot/followed.py", "goal.phase in (Phase.MOVING, Phase.CANCELLING) and", "goal.phase in (Phase.MOVING,) and", ROBOT),
    Fault("commands/console.py", "partial(self._end, console, LEAVE)", "partial(self._end, console, CANCEL)", CONSOLE + "/test_leaving.py"),
    Fault("station/undo.py", "        if outcome.ok:\n            before", "        if True:\n            before", "tests/parameters"),
    Fault("verbs/parameters.py", "return await station.set_parameters(parameter.node, changed)", "return await station.robot.set_parameters(parameter.node, changed)", "tests/hosting/test_reloading.py tests/plain/test_plain.py"),
    Fault("plain/plain.py", "if event.number not in self._printed and", "if event.count == 1 and event.number not in self._printed and", "tests/plain/test_plain.py"),
    Fault("plain/plain.py", "if any(ended.mine and ended.phase != Phase.ARRIVED for ended in snapshot.history):", "if False:", "tests/plain/test_plain.py"),
    Fault("plain/plain.py", "self._failed or verb.id == \"skip\"", "self._failed", "tests/plain/test_plain.py"),
    Fault("plain/plain.py", "shlex.split(line.text)", "line.text.split()", "tests/plain/test_plain.py"),
    Fault("widgets/rows.py", "page, all_of_them = max(self.size.height - 1, 1),", "page, all_of_them = 1,", "tests/widgets/test_events.py"),
    Fault("widgets/goal_panel.py", "            self._draft = [field.value for field in self.fields]\n", "            pass\n", "tests/widgets/test_queue.py"),
    Fault("widgets/goal_panel.py", "self._draft = [field.value for field in self.fields]", "self._draft = [self.fields[0].value, *self._draft[1:]]", "tests/robots/test_rover.py"),
    Fault("widgets/field.py", "for char in text.strip() if not", "for char in text if not", "tests/widgets/test_field.py"),
    Fault("station/recall.py", "[*others, typed][-MOST:]", "[*others, typed]", "tests/widgets/test_queue.py"),
    Fault("station/recall.py", "isinstance(texts, list)][-MOST:]", "isinstance(texts, list)]", "tests/widgets/test_queue.py"),
    Fault("app.py", "typed][-recall.MOST :]", "typed]", "tests/widgets/test_queue.py"),
    Fault("app.py", "*since][-recall.MOST :]", "*since]", "tests/widgets/test_queue.py"),
    Fault("words/state.py", "if seconds < 120 else", "if seconds < 61 else", ROBOT + "/test_checks.py"),
    Fault("widgets/rows.py", "self._width = self.scrollable_content_region.width", "self._width = self.size.width", "tests/widgets/test_parameters.py"),
    Fault("widgets/rows.py", "        text = crop(text, left + self._width)\n", "", "tests/widgets/test_parameters.py"),
    Fault("screens/main.py", "            self._show_panel(message.panel, self._view)\n", "            pass\n", CONSOLE + "/test_operating.py"),
    Fault("widgets/history_panel.py", "view.snapshot.history, known)", "view.snapshot.history)", "tests/station/test_history.py"),
    Fault("station/queue.py", "            self.held = \"STOP\"  #", "            self.hold(\"STOP\")  #", "tests/widgets/test_queue.py"),
    Fault("station/undo.py", "one is not edit", "one != edit", "tests/parameters/test_undo.py"),
    Fault("station/undo.py", "        if missing:  #", "        if False:  #", "tests/parameters/test_undo.py"),
    Fault("station/undo.py", "[-LIMIT:]", "", "tests/parameters"),
    Fault("commands/console.py", "goal is None or console.station.attached:", "True:", CONSOLE + "/test_leaving.py"),
    Fault("plain/plain.py", "        await self._hold(lambda: self._are_answered(last))\n", "", "tests/plain/test_plain_stops.py"),
    Fault("robot/parameters.py", "            if node in self._by_node:  #", "            if False:  #", ROBOT),
    Fault("robot/telemetry.py", "ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT", "ReliabilityPolicy.RELIABLE", ROBOT),
    Fault("robot/services.py", "                if client is not None:\n                    client.remove_pending_request(future)\n                future.cancel()\n", "                pass\n", ROBOT),
    Fault("parameters/save_load.py", "[-1:]", "[:1]", "tests/parameters"),
    Fault("parameters/save_load.py", "        temporary.unlink(missing_ok=True)", "        pass", "tests/parameters"),
    Fault("station/journal.py", "lost, self._lost = self._lost, 0", "lost = self._lost", "tests/station/test_journal.py"),
    Fault("station/journal.py", "self._lost += lost + 1", "pass", "tests/station/test_journal.py"),
    Fault("station/journal.py", "while not lock(descriptor):", "while False and not lock(descriptor):", "tests/station/test_journal.py"),
    Fault("session.py", "and event.count in _COUNTS", "", "tests/station/test_journal.py"),
    Fault("cli.py", "(FAILED if stuck or lost else 0)", "0", "tests/terminal/test_terminal.py"),
    Fault(BRINGUP + "motor_controller.py", "CancelResponse.REJECT if self.outcome.done() else CancelResponse.ACCEPT", "CancelResponse.ACCEPT", "tests/nodes"),
    Fault(E + "executors.py", " and entity._node in self._nodes:  # it may", ":  # it may", CONTRACT),
    Fault(E + "action/server.py", "        if goal_id not in self._goal_handles:\n", "        if True:\n", CONTRACT),
    Fault("embedded/fields.py", "            return lambda value: value[:]\n", "            return lambda value: value\n", CONTRACT),
    Fault(E + "_parameter_rules.py", "1e-6", "1e-2", CONTRACT),
    Fault("embedded/import_hook.py", 'os.environ.get("AMENT_PREFIX_PATH", "")', '""', "tests/embedded"),
    # goals that end at once, rounds of reading, tones, alarms that ring, events that are saved
    Fault("robot/goals.py", "or (alone and self._was_short(action, goal_id, status))", "", ROBOT),
    Fault("robot/goals.py", "return _seconds(status) >= action.since", "return True", ROBOT),
    Fault("robot/goals.py", "            self._over.append(one.id)\n", "", ROBOT),
    Fault("robot/rounds.py", "self._next = now + PERIOD", "self._next = now", ROBOT),
    Fault("robot/rounds.py", "min(MOST, 1 + int(len(self._left) / PERIOD))", "len(self._left)", ROBOT),
    Fault("terminal/themes.py", '"off": ("background", 3.1)', '"off": ("background", 2.5)', "tests/screens/test_contrast.py"),
    Fault("screens/main.tcss", "#stop.-stopped { background: $stopped; color: $text; }", "#stop.-stopped { background: $error; color: $error; }", "tests/screens/test_contrast.py"),
    Fault("station/alarms.py", "            and which not in self._told\n", "", "tests/terminal/test_notice.py"),
    Fault("terminal/app.py", "news and not self.station.quiet and", "news and", "tests/terminal/test_notice.py"),
    Fault("commands/events.py", "reversed(console.main.events.shown)", "console.view.snapshot.events", "tests/widgets/test_events.py"),
    Fault("commands/parameters.py", "selected, not selected.value)", "selected, selected.value)", "tests/widgets/test_parameters.py"),
    Fault("keyed_app.py", "(is_inside or self.main.is_full)", "is_inside", "tests/widgets/test_events.py"),
    # forty more
    Fault("station/alarms.py", "    LOW: 2.0,", "    LOW: 0.0,", "tests/station/test_alarms.py"),
    Fault("station/alarms.py", "SHELF_TIME = 600.0", "SHELF_TIME = 6.0", "tests/station/test_alarms.py " + CONSOLE + "/test_alarms.py"),
    Fault("station/alarms.py", "        if battery.percentage <= 0.0:", "        if battery.percentage < 0.0:", "tests/station/test_alarms.py"),
    Fault("station/alarms.py", "    return is_below or health(snapshot) == \"low\"", "    return is_below", "tests/widgets/test_parameters.py " + ROBOT + " tests/station/test_alarms.py"),
    Fault("station/alarms.py", "    return is_below or health(snapshot) == \"low\"", "    return health(snapshot) == \"low\"", "tests/station/test_alarms.py"),
    Fault("station/station.py", "            self._record(self._board.acknowledge(alarm, self.clock.now()))", "            self._board.acknowledge(alarm, self.clock.now())", "tests/station/test_journal.py"),
    Fault("robot/telemetry.py", "= LEAST_SILENCE  # nobody is there to say more", "= UNMEASURED", ROBOT + "/test_silence.py"),
    Fault("robot/telemetry.py", "None if latched else UNMEASURED", "UNMEASURED", ROBOT + "/test_silence.py"),
    Fault("robot/period.py", "max(3 * period, LEAST_SILENCE)", "60.0", ROBOT + " " + CONSOLE + "/test_operating.py"),
    Fault("robot/state.py", "self.remaining * took / driven", "self.remaining * driven / took", CONSOLE),
    Fault("robot/graph.py", "            if count(f\"{action}/_action/send_goal\"):\n", "            if True:\n", ROBOT + " " + CONSOLE),
    Fault("robot/mailbox.py", "if self._waiting or self._loop is None:", "if self._loop is None:", ROBOT + "/test_mailbox.py"),
    Fault("robot/mailbox.py", "            snapshot = self._latest\n", "            snapshot = Snapshot()\n", ROBOT + "/test_mailbox.py"),
    Fault("robot/events.py", "_READING.sub(\"#\", text)", "re.sub(r\"[0-9.]+\", \"#\", text)", ROBOT + "/test_events.py"),
    Fault("robot/events.py", "LIMIT = 1000", "LIMIT = 100_000", ROBOT),
    Fault("robot/events.py", "text, source = harmless(event.text), ", "text, source = event.text, ", ROBOT + " " + CONSOLE),
    Fault("robot/followed.py", "SILENCE = 3.0", "SILENCE = 300.0", ROBOT + "/test_followed.py"),
    Fault("robot/goals.py", "            one.is_cancelled = True\n        if one.goal.phase == Phase.SENT:", "            pass\n        if one.goal.phase == Phase.SENT:", ROBOT + "/test_cancel_on_its_way.py"),
    Fault("robot/goals.py", "        if one.is_cancelled:\n            return Outcome(Code.CANCELLED, NEVER_LEFT)", "", ROBOT + "/test_cancel_on_its_way.py"),
    Fault("station/ledger.py", "goal.mine and goal.number > self.before", "goal.number > self.before", ROBOT + "/test_cancel_on_its_way.py"),
    Fault("verbs/speak.py", "        left = PATIENCE - station.age", "        left = PATIENCE", "tests/plain/test_plain_patience.py"),
    Fault("robot/client.py", "            if self._stopping.latch is Latch.UNCERTAIN and not gate.is_shut:", "            if False:", ROBOT + "/test_latch.py"),
    Fault("robot/client.py", "return self._clock.monotonic() - self._motion_changed <= _RESTART", "return False", ROBOT + "/test_latch.py"),
    Fault("robot/stopping.py", "            self.look_at_holders()  # it may be another node that says so", "            pass", ROBOT + "/test_latch.py"),
    Fault("hosting/host.py", "        if service in new.state.serves:", "        if False:", ROBOT + "/test_latch.py"),
    Fault("robot/followed.py", "            self.node_gone()\n            return", "            pass", ROBOT + "/test_goal_without_a_node.py"),
    Fault("hosting/host.py", "            self._gone(hosted)\n", "", ROBOT + "/test_goal_without_a_node.py"),
    Fault("hosting/host.py", "if name not in left])", "])", ROBOT + "/test_goal_without_a_node.py"),
    Fault("robot/goals.py", "one.update(phase=before, cancel_asked=None)", "pass", ROBOT),
    Fault("robot/services.py", "DEADLINE = 2.0", "DEADLINE = 20.0", ROBOT),
    Fault("robot/parameters.py", "        if not answer.result.successful:\n", "        if False:\n", "tests/widgets/test_parameters.py"),
    Fault("robot/parameter_values.py", "    if parameter.read_only:\n        raise", "    if False:\n        raise", ROBOT),
    Fault("robot/parameter_values.py", "not parameter.low <= value <= parameter.high", "value > parameter.high", ROBOT),
    Fault("robot/stopping.py", "        if self.open is not None:\n            self.over()", "        pass", ROBOT + " " + CONSOLE),
    Fault("hosting/host.py", "            self._on_change(self)\n", "            pass\n", ROBOT),
    Fault("hosting/host.py", "            return False\n        self._executor.shutdown(0)", "            return True\n        self._executor.shutdown(0)", "tests/terminal/test_terminal.py"),
    Fault("shutdown.py", "    if on_disconnect == LEAVE:\n", "    if False:\n", "tests/station/test_shutdown.py"),
    Fault("shutdown.py", "        if self._task is None:\n", "        if True:\n", "tests/station/test_shutdown.py"),
    Fault("keyed_app.py", "        if self.screen is not self.main or (", "        if (False and ", "tests/commands/test_registry.py"),
    Fault("app.py", "or not (command.runs_blocked or command.insists):", "and False:", CONSOLE),
    Fault("app.py", "        if isinstance(self.screen, Confirm):\n", "        if False:\n", CONSOLE + "/test_leaving.py"),
    Fault("app.py", "act = answers.get(answer)", "act = next(iter(answers.values()))", CONSOLE + "/test_keys.py"),
    Fault("commands/robot.py", "is_on = any(", "is_on = not any(", CONSOLE + "/test_operating.py tests/robots"),
    Fault("keyed_app.py", "return priority and not self._is_typed and await", "return False and await", "tests/widgets/test_field.py"),
    Fault("screens/confirm.py", 'self.query_one("#answer-0")', 'self.query_one("#answer-1")', CONSOLE + "/test_operating.py"),
    Fault("widgets/rows.py", "            self.cursor = next(found, min(self.cursor, max(len(items) - 1, 0)))", "            pass", "tests/widgets/test_events.py"),
    Fault("widgets/trend.py", "left * (last_at - at) / gained", "left * gained / (last_at - at)", "tests/screens/test_snapshots.py"),
    Fault("terminal/driver.py", "        self._tell(cast(SteadyApp, self._app).hang_up)\n", "        pass\n", "tests/terminal/test_terminal.py"),
    Fault("terminal/driver.py", "                self._dropping = True\n", "                return\n", "tests/terminal/test_driver.py tests/terminal/test_terminal.py"),
    Fault(E + "timer.py", "            self._next_ns += missed * self._period_ns\n", "            pass\n", CONTRACT),
    Fault(E + "subscription.py", "encode(message) if self.raw else message.__received__()", "encode(message) if self.raw else message", CONTRACT),
    Fault(E + "_node_parameters.py", "        if self._descriptors[name].read_only:\n            raise ParameterImmutableException(name)\n", "", CONTRACT),
    Fault(BRINGUP + "battery_model.py", "HYSTERESIS = 3.0", "HYSTERESIS = 0.0", "tests/nodes"),
    Fault(BRINGUP + "motor_controller.py", "        self.emergency_stopped = True\n", "        pass\n", "tests/nodes"),
    # robots, the goals of others, the queue
    Fault("robot/readings.py", "return value * field.scale + field.offset", "return value", "tests/robots"),
    Fault("robot/offers.py", "if message_classes.fields(srv_type.Request) != set(fields):\n            return None,", "if False:\n            return None,", ROBOT),
    Fault("robot/telemetry.py", 'said = next(filter(None, lacking.values()), "") or', 'said = "" or', "tests/robots"),
    Fault("robot/forms.py", "if low is not None and not value >= low:", "if False:", "tests/robots " + CONSOLE + "/test_goals.py"),
    Fault("commands/keymap.py", " and not c.yields}", "}", "tests/commands/test_keymap.py"),
    Fault("commands/keymap.py", " and command.id not in lines]", "]", "tests/commands/test_keymap.py"),
    Fault("commands/keymap.py", "        if owner:\n", "        if False:\n", "tests/commands/test_keymap.py"),
    Fault("station/queue.py", "self.hold(ended or _in_the_way(alarms))", "self.hold(_in_the_way(alarms))", "tests/widgets/test_queue.py"),
    Fault("station/queue.py", "self.hold(ended or _in_the_way(alarms))", "self.hold(ended)", "tests/widgets/test_queue.py"),
    Fault("station/queue.py", "if self.held or self._ledger.running_goal(snapshot) is not None:", "if self.held or snapshot.running_goal is not None:", "tests/widgets/test_queue.py"),
    Fault("robot/goals.py", "if one is None or one.goal.mine == another:", "if one is None:", CONSOLE + "/test_others_goals.py"),
    Fault("shutdown.py", "goal is not None and goal.mine else None", "goal is not None else None", "tests/station/test_shutdown.py"),
    Fault("robot/client.py", "        if self.watching:\n            return Outcome(Code.WATCHING, WATCHING)\n", "", ROBOT + "/test_robot.py"),
    Fault("screens/main.py", '        panel.add_class("-broken")', "        pass", CONSOLE + "/test_operating.py"),
    Fault(E + "timer.py", "        if self._now_ns() < self._last_ns:\n", "        if False:\n", CONTRACT),
    Fault("embedded/cdr.py", "    data += bytes(-len(data) % size)\n", "", CONTRACT),
    # nodes of the user's own, the history, dialogs
    Fault("hosting/node_files.py", "                node.destroy_node()  # else", "                pass  # else", "tests/hosting/test_reloading.py"),
    Fault("hosting/host.py", "                self._gone(old)\n            failed", "            failed", "tests/hosting/test_reloading.py"),
    Fault("hosting/host.py", "                self._set_again(new, kept(new.name))", "                pass", "tests/hosting/test_reloading.py"),
    Fault("hosting/host.py", "        except BaseException as error:  # SystemExit", "        except Exception as error:  # SystemExit", "tests/hosting/test_reloading.py"),
    Fault("station/history.py", "None if battery.is_old(now) else battery.percentage", "battery.percentage", "tests/station/test_history.py"),
    Fault("screens/base.py", "event if event.size == size else Resize(size, size)", "event", CONSOLE + "/test_unlucky_moments.py"),
    Fault("screens/base.py", "return (None, None) if gone else", "return", CONSOLE + "/test_unlucky_moments.py"),
    Fault("screens/leaving.py", " if self.is_active else AwaitComplete()", "", CONSOLE + "/test_unlucky_moments.py"),
    Fault("screens/leaving.py", "        if self._left is not None:\n            self.dismiss()", "        pass", CONSOLE + "/test_keys.py"),
    Fault("screens/main.py", "self.focused is None and self.app.app_focus", "self.focused is None", CONSOLE + "/test_unlucky_moments.py"),
    Fault("screens/main.py", "self.focused is None and self.app.app_focus", "False", CONSOLE + "/test_unlucky_moments.py"),
    Fault("keyed_app.py", "if isinstance(self.screen, Leaving) and self.screen.is_asking:", "if False:", "tests/screens/test_bursts.py"),
    Fault("keyed_app.py", "is_void = stops is not None and stops < self._answers_void", "is_void = False", "tests/screens/test_bursts.py"),
    Fault("plain/plain.py", ' or "later" in act.arguments', "", "tests/plain/test_plain_stops.py"),
    Fault("keyed_app.py", "if is_void or self._was_for_a_dialog(event):", "if is_void:", "tests/commands/test_palette.py"),
    Fault("app.py", '            self.closed_by_stop("STOP kept the dialog from opening")\n', "", "tests/screens/test_bursts.py"),
    Fault("recording/bag.py", "            written = Written(written.left_out + 1, written.why or in_one_line(error))\n            continue", "            raise", "tests/black_box/test_bag.py"),
    Fault("recording/store.py", " and not path.is_symlink()", "", "tests/black_box/test_box.py"),
    Fault("recording/box.py", "            self._hand_over(opened)", "            pass", "tests/black_box/test_box.py"),
    Fault("recording/triggers.py", "alarm.priority == Priority.HIGH and ", "", "tests/black_box/test_box.py"),
    Fault("recording/triggers.py", " and not called_off", "", "tests/black_box/test_box.py"),
    Fault("app.py", " and screen.is_mounted:", ":", CONSOLE + "/test_unlucky_moments.py"),
    Fault("commands/palette.py", "any(isinstance(screen, Commands) for screen in console.screens)", "isinstance(console.screen, Commands)", CONSOLE + "/test_unlucky_moments.py"),
    Fault("screens/ask_path.py", 'self.write(".recent", Content', 'self.query_one(".recent", Static).update(Content', "tests/widgets/test_parameters.py"),
    Fault("widgets/parameters_panel.py", "            if not view.changing:\n                self._flash(before)", "            self._flash(before)", "tests/widgets/test_parameters.py"),
    Fault("chapter/moves.py", "        if not self._until(asked.done, _TAKEN):", "        if False:", LEARNERS),
    Fault("widgets/rows.py", "self.shows_cursor and (self.has_focus or self.without_focus)", "self.has_focus or self.without_focus", CONSOLE + "/test_first_look.py"),
    Fault("widgets/parameters_panel.py", "if p.is_changed or not _is_ros_own(p)", "if not _is_ros_own(p)", CONSOLE + "/test_first_look.py"),
    Fault("widgets/panel.py", "        if title != self._title:", "        if title != self.border_title:", CONSOLE + "/test_first_look.py"),
    Fault("app.py", "            begin(self, partial(in_daemon, recall.keep_sent), COMMANDS)\n", "", CONSOLE + "/test_first_look.py"),
    Fault("robot/resources.py", "        if serving != self._serving:", "        if False:", "tests/widgets/test_graph.py"),
    Fault("robot/resources.py", "(tuple(types), node.count_publishers(name))", "(tuple(types), 0)", "tests/widgets/test_graph.py"),
    Fault("words/graph.py", "        return SILENT\n", "        pass\n", "tests/widgets/test_graph.py"),
    Fault("screens/main.py", "        if focused is not None and not self._has_room(focused):", "        if False:", "tests/widgets/test_graph.py"),
    Fault("widgets/panel.py", "view.watching or bool(snapshot", "bool(snapshot", "tests/screens/test_dimmed.py"),
    Fault("terminal/themes.py", '_STOPPED = "#af0000"', '_STOPPED = "#a32549"', "tests/screens/test_dimmed.py"),
    Fault("screens/main.py", "panel is not None and self._asked", "panel is not None", "tests/screens/test_snapshots.py"),
    Fault("hosting/own_interfaces.py", "            check(self._packages)\n", "            pass\n", "tests/embedded/test_own_interfaces.py"),
    # what is drawn
    Fault("terminal/compositor.py", "any(x1 < seen.right and seen.x < x2 for", "any(x1 < seen.right and seen.right <= x2 for", "tests/screens/test_compositor.py"),
    Fault("terminal/compositor.py", "        if self._full_map_invalidated:\n", "        if False:\n", "tests/screens/test_compositor.py"),
    Fault("terminal/compositor.py", "            self._cuts = None\n", "", "tests/screens/test_compositor.py"),
    Fault("widgets/field.py", "virtual_size = Reactive(Size(0, 0))", "virtual_size = Reactive(Size(0, 0), layout=True)", "tests/widgets/test_field.py"),
    # what a terminal sends
    Fault("terminal/sequences.py", "                self._rest_until = self._since + wait + SEQUENCE_WAIT\n", "", "tests/terminal/test_keyboard.py"),
    Fault("terminal/sequences.py", "        elif char in (CANCEL, _SUBSTITUTE):\n            self._abort(char)\n", "", "tests/terminal/test_keyboard.py"),
    Fault("terminal/sequences.py", "            self._wait(self._string_escape)", "            self._state = self._ground", "tests/terminal/test_keyboard.py"),
    Fault("terminal/keyboard.py", "last_moves(text)", "text", "tests/terminal/test_keyboard.py tests/terminal/test_terminal_keys.py"),
    Fault("terminal/keyboard.py", "        except Exception:", "        except OSError:", "tests/terminal/test_keyboard.py"),
    Fault("terminal/keys.py", "_printable(base) or on_qwerty(character)", "character", "tests/terminal/test_keyboard.py"),
    Fault("terminal/paste.py", "self._silence >= ALONE and", "True and", "tests/terminal/test_paste.py"),
    Fault("terminal/paste.py", "self.waiting and now - self._heard >= ALONE", "self.waiting", "tests/terminal/test_paste.py"),
    Fault("terminal/driver.py", "            self.write(_ALTERNATE_KEYS)", "            pass", "tests/terminal/test_terminal_keys.py"),
    Fault("terminal/app.py", "        self.notify(text, severity=\"warning\", markup=False)", "        pass", "tests/terminal/test_terminal_keys.py"),
    # the engine's strictness
    Fault("embedded/fixed_array.py", "        if len(self) != 1:\n            raise ValueError(_AMBIGUOUS)\n        return bool(self[0])", "        return self.all()", CONTRACT),
    Fault("embedded/fixed_array.py", "        return Part(", "        return FixedArray(", "tests/embedded/test_fixed_arrays.py"),
    Fault("embedded/fields.py", "not isinstance(value, (Sequence, Set))", "not hasattr(value, '__iter__')", CONTRACT),
    Fault("embedded/fields.py", "        return lambda value: list(check(value))  #", "        return check  #", CONTRACT),
    Fault("embedded/fields.py", "            if value.typecode != code:", "            if False:", CONTRACT),
    Fault(E + "_entity.py", "        if self._destroyed:\n            raise InvalidHandle", "        if False:\n            raise InvalidHandle", CONTRACT),
    Fault(E + "qos.py", "    return offered.nanoseconds == 0 or requested", "    return requested", CONTRACT + "/test_events.py"),
    Fault("embedded/absent.py", "    if name in MODULES:", "    if False:", "tests/embedded/test_absent.py"),
    Fault("embedded/absent.py", "        if value is not None:", "        if False:", "tests/embedded/test_absent.py"),
    Fault(E + "event_handler.py", "        _refuse_timed(self)\n        event, qos, kind = QoSPublisher", "        event, qos, kind = QoSPublisher", "tests/embedded/test_absent.py"),
    Fault(E + "type_support.py", "    if msg_or_srv_type._TYPE_SUPPORT is None:\n        raise", "    if False:\n        raise", CONTRACT),
    Fault("station/recall.py", "others = [texts for texts in _texts(known, form) if texts != typed]", "others: list[list[str]] = []", CONSOLE + "/test_keys.py"),
    Fault(E + "_arguments.py", "found |= values", "found = values | found", CONTRACT),
    Fault(E + "_names.py", "that starts with a number\", digit.start(1)", "that starts with a number\", digit.start(0)", CONTRACT),
    Fault(E + "_names.py", "        if rule.kind not in (None, kind):\n            continue\n", "", CONTRACT),
    Fault(E + "_node_parameters.py", "        if known:\n", "        if False:\n", CONTRACT),
    Fault(E + "impl/rcutils_logger.py", "        if self._first[0] != severity:\n", "        if False:\n", CONTRACT),
    Fault(E + "action/server.py", "_expires <= self._clock.now().nanoseconds", "_expires <= __import__('rclpy')._time_source.time_ns()", CONTRACT),
    Fault(E + "action/client.py", "            while True:\n                self._take_status(self._status._queue.popleft())\n", "            pass\n", CONTRACT),
    Fault(E + "context.py", "            if self._has_begun:\n                raise", "            if self._ok:\n                raise", CONTRACT),
    Fault(E + "lifecycle/_states.py", "    if state == error:\n", "    if False:\n", CONTRACT),
    Fault(E + "lifecycle/publisher.py", "    @SimpleManagedEntity.when_enabled\n", "", CONTRACT),
    Fault(E + "lifecycle/node.py", "            if said != _SUCCESS:\n                return said\n", "", CONTRACT),
    Fault("session.py", " and str(override.value) in said", "", "tests/test_cli.py"),
    Fault("terminal/compositor.py", "        if self._dirty is None:  # all\n", "        if True:\n", "tests/screens/test_compositor.py"),
    Fault("station/history.py", "            del column[:-_KEPT]", "            pass", "tests/station/test_history.py"),
    # coroutines, executors, groups, handles and surfaces as rclpy's; our own errors without their class
    Fault(E + "executors.py", " and entity._is_awaited()", "", CONTRACT),
    Fault(E + "task.py", "            self._coroutine.close()\n", "            pass\n", CONTRACT),
    Fault(E + "task.py", "self._exception is not None and not self._is_retrieved", "False", CONTRACT),
    Fault(E + "executors.py", "        if num_threads == 1:\n", "        if False:\n", CONTRACT),
    Fault(E + "executors.py", "elif nodes is not None and item._node not in nodes:", "elif False:", CONTRACT),
    Fault(E + "executors.py", "        with suppress(ExternalShutdownException):  # this one ends without a word\n", "        if True:\n", CONTRACT),
    Fault(E + "callback_groups.py", "        assert entity.callback_group is self or self.has_entity(entity)\n        return", "        return", CONTRACT),
    Fault(E + "action/server.py", "            expired.destroy()\n", "", CONTRACT),
    Fault(E + "action/server.py", "        if self._was_destroyed:\n", "        if False:\n", CONTRACT),
    Fault(E + "_node_parameters.py", "[one for callback in before for one in callback(parameter_list)]", "list(before[0](parameter_list))", CONTRACT),
    Fault(E + "context.py", "        if self._has_begun and not self._ok:\n", "        if False:\n", CONTRACT),
    Fault("embedded/messages.py", "                values[name] = array(code, values[name])\n", "                pass\n", CONTRACT),
    Fault(E + "service.py", " and self._is_awaited()", "", CONTRACT),
    Fault("errors.py", "text if isinstance(error, ArchoError) else ", "", "tests/hosting/test_node_files.py"),
    Fault("cli.py", "_columns() - 2", "_columns() - 22", "tests/test_cli.py"),
    # held keys, the queue, alarms, the goal field, the end
    Fault("commands/robot.py", "if console.repeated and not is_ours:", "if False:", CONSOLE + "/test_goals.py"),
    Fault("robot/client.py", "if queued and (self._stopping.open is not None or", "if queued and (", ROBOT + "/test_robot.py"),
    Fault("station/queue.py", "if alarm.name in (LOW, EMPTY) and", "if alarm.name == LOW and", "tests/widgets/test_queue.py"),
    Fault("station/station.py", "if self._held and not before:", "if self._held:", "tests/widgets/test_queue.py"),
    Fault("verbs/nodes.py", "grave = (_last(goal.kind.action), _stop(station))", "grave = (_last(goal.kind.action),)", "tests/widgets/test_nodes.py"),
    Fault("station/alarms.py", "return shelved, self.acknowledged, self.is_over, _ORDER", "return shelved, self.acknowledged, False, _ORDER", "tests/station/test_alarms.py"),
    Fault("station/alarms.py", "monotonic >= alarm.shelf_ends:", "now >= (alarm.shelved_until or 0.0):", "tests/station/test_alarms.py"),
    Fault("station/alarms.py", "until = now + alarm.shelf_ends - monotonic", "until = alarm.shelved_until or 0.0", "tests/station/test_alarms.py"),
    Fault("station/alarms.py", "{(alarm.name, alarm.since): alarm", "{(alarm.name, 0.0): alarm", "tests/station/test_alarms.py"),
    Fault("station/alarms.py", "if alarm.name == LOW and EMPTY in found:", "if False:", "tests/station/test_alarms.py"),
    Fault("station/alarms.py", "if low is not None and low.is_over and", "if False and low is not None and", "tests/station/test_alarms.py"),
    Fault("station/alarms.py", "    if snapshot.outlived:\n", "    if False:\n", "tests/station/test_alarms.py"),
    Fault("robot/values.py", "if not _WHOLE.fullmatch(stripped):", "if not stripped.lstrip('+-').isdecimal():", ROBOT + "/test_forms.py"),
    Fault("robot/values.py", "if not _NUMBER.fullmatch(text.strip()):", "if False:", ROBOT + "/test_forms.py"),
    Fault("robot/values.py", 'lstrip("+-0")', 'lstrip("+-")', ROBOT + "/test_forms.py"),
    Fault("screens/base.py", "            widget.action_select_all()", "            pass", "tests/commands/test_palette.py"),
    Fault("widgets/field.py", 'return self.value != "" or', "return", CONSOLE + "/test_goals.py"),
    Fault("cli.py", 'streams["stderr"] = sys.__stderr__', "pass", "tests/test_cli.py"),
    Fault("robot/client.py", "self._goals.are_over = True", "pass", "tests/station/test_shutdown.py"),
    # robot files, interface files, what survived
    Fault("robot_file/check.py", 'has several types: {\', \'.join(found)}" if len(found) > 1 else ""', 'has several types: {\', \'.join(found)}" if False else ""', ROBOT + "/test_checks.py"),
    Fault(E + "qos.py", "max(self.depth, 1)", "max(self.depth, 2)", CONTRACT),
    Fault(E + "action/server.py", "        if not self.is_cancel_requested:\n            self._update(states.EXECUTE)", "        if True:\n            self._update(states.EXECUTE)", CONTRACT),
    Fault(E + "node.py", "own.remaps + everybodys.remaps", "everybodys.remaps + own.remaps", CONTRACT),
    Fault(BRINGUP + "motor_controller.py", ' for p in parameters) and self.goal is not None:', ' for p in parameters):', "tests/nodes"),
    Fault(BRINGUP + "motion.py", "max(passed, self._taken)", "passed", "tests/nodes"),
    Fault("robot/readings.py", "abs(value) > field.beyond", "value > field.beyond", "tests/robots"),
    Fault("robot_file/faults.py", "        if word in reserved.RESERVED:\n", "        if False:\n", "tests/robots/test_load.py"),
    Fault("robot_file/typed_yaml.py", " and not node.style and", " and", "tests/robots/test_load.py"),
    Fault("robot_file/written.py", 'text.lower() != "none"', "True", "tests/robots/test_load.py"),
    Fault("robot/forms.py", "    if is_number(leaf):  #", "    if True:  #", "tests/robots/test_misfits.py"),
    Fault("robot/offers.py", "        elif not forms.is_number(leaf) and", "        elif False and", "tests/robots/test_misfits.py"),
    Fault("cli.py", "    if ros_args:\n", "    if False:\n", "tests/test_cli.py"),
    Fault("cli.py", "made.parse_intermixed_args([*before, *rest])", "made.parse_args(rest)", "tests/test_cli.py"),
    Fault("cli.py", "    if options.robot:  #", "    if False:  #", "tests/test_cli.py"),
    Fault("embedded/idl_values.py", "for base in (10, 0):", "for base in (0,):", "tests/embedded"),
    Fault("embedded/import_hook.py", "        if wanted in self._making:\n", "        if False:\n", "tests/embedded"),
    Fault("embedded/messages.py", "        if elements > MOST_ELEMENTS:\n", "        if False:\n", "tests/embedded"),
    Fault(E + "service.py", "        self._use()\n        message: Any", "        message: Any", CONTRACT),
    Fault(E + "executors.py", "if asked != self._asked:", "if False:", CONTRACT),
    Fault(E + "impl/rcutils_logger.py", "_BY_WARN if by_warn else here", "here", CONTRACT),
    Fault("commands/console.py", "return self._end(console, station.on_disconnect)  #", "return console.exit()  #", CONSOLE + "/test_leaving.py"),
    # values as they were meant, and one reading of them
    Fault("robot/fields.py", "if not low <= value <= high:", "if False:", ROBOT + "/test_fields.py"),
    Fault("robot/fields.py", "if size is not None and len(value) != int(size):", "if False:", ROBOT + "/test_fields.py"),
    Fault("robot/fields.py", "if most is not None and len(value) > int(most):", "if False:", ROBOT + "/test_fields.py"),
    Fault("robot/fields.py", "if most is not None and len(value) > most:", "if False:", ROBOT + "/test_fields.py"),
    Fault("robot/fields.py", 'if kind == "float" and math.isfinite(number) and', "if False and", ROBOT + "/test_fields.py"),
    Fault("robot/fields.py", "or isinstance(value, bool):\n        raise ValueError(\"is not a whole", "or False:\n        raise ValueError(\"is not a whole", ROBOT + "/test_fields.py"),
    Fault("robot/fields.py", "if other[: len(one)] == one:", "if False:", ROBOT + "/test_fields.py"),
    Fault("robot/fields.py", "value.startswith(_MARKS)", "False", ROBOT + "/test_fields.py"),
    Fault("robot_file/faults.py", "if label.lower() in labels:", "if False:", "tests/robots/test_load.py"),
    Fault("widgets/field.py", "len(text.splitlines()) > 1:", "False:", "tests/widgets/test_field.py"),
    Fault("robot/fields.py", 'if "\\0" in value:', "if False:", ROBOT + "/test_fields.py"),
    Fault("robot/goals.py", "            one.end(Phase.REFUSED, reason)\n            return Outcome(Code.REFUSED, reason)\n        future", "            return Outcome(Code.REFUSED, reason)\n        future", ROBOT + "/test_never_sent.py"),
    Fault("robot/messages.py", "finite(path, degrees)", "degrees", ROBOT + "/test_goal_values.py"),
    Fault("robot/messages.py", "isinstance(value, bytes) and not as_bytes", "isinstance(value, bytes)", ROBOT + "/test_written.py"),
    Fault("robot/parameters.py", "if value == [] and known is not None:", "if False:", ROBOT + "/test_parameters_are_checked.py"),
    Fault("robot/parameters.py", "checked(kinds[field], value, name)", "value", ROBOT + "/test_parameters_are_checked.py"),
    Fault("robot/parameter_values.py", "checked(_FIELDS[parameter.type], value, \"value\")", "value", ROBOT + "/test_parameters_are_checked.py"),
    Fault("robot/forms.py", "if high is not None and not value <= high:", "if high is not None and value > high:", ROBOT + "/test_forms.py"),
    Fault("robot/forms.py", "    checked(leaf.type, value, label)\n", "", ROBOT + "/test_forms.py"),
    Fault("robot/ros2_command.py", 'f" {flow(v)}" if flow(v)[0] == "-" else flow(v)', "flow(v)", ROBOT + "/test_written.py"),
    Fault("robot_file/written.py", "_NAME.fullmatch(text) and yaml.safe_load(text) == text", "_NAME.fullmatch(text)", ROBOT + "/test_written.py"),
    Fault("robot_file/written.py", "_NAME.fullmatch(text) and yaml", "yaml", ROBOT + "/test_written.py"),
    Fault("embedded/core_schema.py", '            raise _fault(key, f"{_shown(key.value)} is given twice")\n', "            pass\n", "tests/embedded/test_core_schema.py"),
    Fault("embedded/core_schema.py", '{"yaml_implicit_resolvers": {}}', "{}", "tests/embedded/test_core_schema.py"),
    Fault("embedded/core_schema.py", "if math.isinf(found) and not infinite:", "if False:", "tests/embedded/test_core_schema.py"),
    Fault("robot_file/typed_yaml.py", "        return _any(node, path)\n", '        return yaml.SafeLoader("").construct_object(node, deep=True)\n', "tests/robots/test_load.py"),
    Fault("screens/edit_parameter.py", "                return self._offered\n", "                pass\n", "tests/widgets/test_parameters.py"),
    # the board, limits that the robot holds, a node's dialog, and an empty graph
    Fault("widgets/field.py", 'apart = " " if self.value[-1:].strip() else ""', 'apart = ""', "tests/widgets/test_board.py"),
    Fault("widgets/goal_panel.py", "scroll_visible=False, from_app_focus=True)", "scroll_visible=False)", "tests/widgets/test_board.py"),
    Fault("widgets/goal_panel.py", "seen = self._has_board and (has_room or", "seen = self._has_board and (True or", "tests/widgets/test_board.py"),
    Fault("widgets/board.py", "        elif marks != before:\n", "        else:\n            self.refresh()\n", "tests/widgets/test_board.py"),
    Fault("words/board.py", "reversed([*enumerate(waiting)])", "enumerate(waiting)", "tests/widgets/test_board.py"),
    Fault("words/board.py", "        latest = False\n", "", "tests/widgets/test_board.py"),
    Fault("widgets/board.py", 'Binding("enter", "take"', 'Binding("f12", "take"', "tests/widgets/test_board.py"),
    Fault("verbs/goals.py", "forms.check_ranges(self._leaves or (), form, goal)", "pass", "tests/verbs"),
    Fault("verbs/goals.py", " and heard\n", "\n", "tests/verbs"),
    Fault("verbs/speak.py", " if acts else verb.blocked(station)", "", "tests/verbs"),
    Fault("robot/limits.py", " and said not in self._said:", ":", ROBOT + "/test_limits.py"),
    Fault("robot/state.py", "low=self.limit(given.low), high=self.limit(given.high)", "low=None, high=None", "tests/widgets/test_board.py"),
    Fault("robot/nodes.py", ", _request(name, level), gate=gate", ", _request(name, level)", "tests/widgets/test_node_dialog.py"),
    Fault("robot/nodes.py", 'for one in levels if one != "UNSET"', "for one in levels", "tests/widgets/test_node_dialog.py"),
    Fault("station/alarms.py", "if waiting and not snapshot.has_clock:", "if waiting:", "tests/station/test_alarms.py"),
    Fault("station/alarms.py", "heard or hosted or snapshot.nodes", "heard or snapshot.nodes", "tests/station/test_alarms.py"),
    # learners' files, and the nodes of a process
    Fault("hosting/host.py", "self._on_change, self._rename)", "self._on_change)", "tests/hosting/test_host.py"),
    Fault("hosting/host.py", "            if old.state.life == Life.UP:\n                return", "            if False:\n                return", "tests/hosting/test_host.py"),
    Fault("cli.py", 'in ("--ros-args", "--") and inside != (word == "--ros-args"):', 'in ("--ros-args", "--"):', "tests/test_cli.py"),
    Fault("hosting/source.py", "        roots = [*self._main()]", "        roots: list[ast.AST] = []", LEARNERS),
    Fault("hosting/source.py", "None if number == 1 else number", "number", LEARNERS),
    Fault("hosting/host.py", "(h for h in named if h.state.life != Life.UP)", "(h for h in named)", LEARNERS),
    Fault("chapter/asker.py", "self._began + _WATCHED - self.now()", "0.0", LEARNERS),
    Fault("chapter/moves.py", "        if lasted < _SHORTEST:", "        if False:", LEARNERS),
    Fault("hosting/workers.py", "            if error_of() is not None:", "            if False:", LEARNERS),
    Fault("hosting/host.py", "for thread in (self._thread, *workers) if", "for thread in (self._thread,) if", "tests/hosting/test_reloading.py"),
    Fault("chapter/asker.py", "            self._host.start_node(hosted.name)\n", "", LEARNERS),
    Fault("chapter/asker.py", "                if hosted.state.life == Life.CRASHED:\n                    raise", "                if False:\n                    raise", LEARNERS),
    Fault("chapter/topics.py", "        if said and asker.until(is_low, _AGAIN):", "        if False:", LEARNERS),
    Fault("chapter/services.py", "    if any(before.get(name) and not value", "    if False and any(before.get(name) and not value", LEARNERS),
    Fault("chapter/asker.py", "            if line.startswith(_THREAD):", "            if False:", LEARNERS),
    Fault("hosting/source.py", "                if called is not None and called not in roots:", "                if False:", LEARNERS),
    Fault("session.py", "            rclpy.shutdown = rclpy.try_shutdown = _refuse_shutdown", "            pass", LEARNERS),
    Fault("chapter/topics.py", "_HIGH = 87.5, 55.0, 21.0", "_HIGH = 87.5, 55.0", LEARNERS),
    Fault("chapter/topics.py", "_LOW = 19.0, 5.0", "_LOW = (19.0,)", LEARNERS),
    Fault("chapter/services.py", "        if abs(value) < _TICKS:  #", "        if False:  #", LEARNERS),
    Fault("chapter/moves.py", "_SHELVES = 11, 6", "_SHELVES = 12, 6", LEARNERS),
    Fault("chapter/check.py", "    return 1 if failed or nothing else 0", "    return 1 if failed else 0", LEARNERS),
    Fault("chapter/names.py", "return bool(own) and (own <= words or words <= own)", "return False", LEARNERS),
]  # fmt: skip


def path_of(fault: Fault, folder: Path = ROOT) -> Path:
    """Where a fault is planted."""
    return folder / ("" if fault.file.startswith("nodes/") else "archo_tui") / fault.file


def noticed(folder: Path, fault: Fault) -> bool:
    """Plant a fault, run the tests that should notice it, and take it out again."""
    path = path_of(fault, folder)
    text = path.read_text(encoding="utf-8")
    assert fault.line in text, f"{fault.file} does not say {fault.line!r}"
    path.write_text(text.replace(fault.line, fault.instead, 1), encoding="utf-8")
    words = [sys.executable, "-m", "pytest", "-n0", "-q", "-x", *fault.tests.split()]
    environ = os.environ | {"PYTHONPATH": f"{folder}:{folder / 'nodes'}"}
    try:
        done = subprocess.run(
            words, cwd=folder, env=environ, capture_output=True, check=False, timeout=120
        )
    except subprocess.TimeoutExpired:
        return True
    finally:
        path.write_text(text, encoding="utf-8")
    assert done.returncode in (0, 1, 2), done.stdout.decode()  # 2: stopped at the first failure
    return done.returncode != 0


def main(words: list[str]) -> int:
    chosen = [fault for fault in FAULTS if all(word in "".join(fault) for word in words)]
    missed = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "copy"
        ignored = shutil.ignore_patterns(".venv", ".git", "*.egg-info", "__pycache__")
        shutil.copytree(ROOT, folder, ignore=ignored, symlinks=True)
        for fault in chosen:
            seen = noticed(folder, fault)
            missed += not seen
            line = " ".join(fault.line.split())[:70]
            print(f"{'noticed ' if seen else 'MISSED  '} {fault.file}: {line}", flush=True)
    print(f"{len(chosen) - missed} of {len(chosen)} noticed")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
