"""What the page says is not emulated is just what is missing: every public name is compared."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent

# of each part of the page's list, by a word of it: the names that it stands for
NOT_EMULATED = {
    "C objects behind handles": r"get_c_|\.(un)?track_node$|g_\w+$",
    "waitables": r"[Ww]aitable|add_to_wait_set|\.is_ready$|\.take_data$|\.execute$"
    r"|(add|remove)_future|notify_|create_event_handlers|\.(QoS)?EventHandler(\.|$)|EventHandlerData"
    r"|TimeoutObject|WorkTracker|get_num_entities",
    "type descriptions": r"type_description|start_type_description",
    "type hashes": r"type_hash",
    "guard conditions": r"guard",
    "deadline and liveliness events": r"QoS(Liveliness\w+|\w+DeadlineMissed)Info",
    "content filters": r"content_filter|cft",
    "QoS overriding options": r"qos_overrid",
    "the comparison of two profiles": r"qos_check_compatible|QoSCompatibility",
    "service introspection": r"introspection",
    "callbacks on a clock's jump": r"jump_callback|Jump(Threshold|Handle)|TimeJump|ClockChange",
    "rclpy.parameter_event_handler": r"parameter_event_handler",
    "rclpy.wait_for_message": r"wait_for_message",
    "rclpy.experimental": r"experimental",
    "signal handlers": r"rclpy\.signals\.",
    "logging set-up": r"rclpy\.logging\.(initialize|shutdown)",
    "filter classes": r"rcutils_logger\.",
}
# what a module of rclpy only uses: constants and types that it imports, words for type checkers
USED = re.compile(
    r"\.(TYPE_CHECKING|annotations|Lock|TOPIC_SEPARATOR_STRING|PARAMETER_SEPARATOR_STRING|S_TO_NS"
    r"|HIDDEN_NODE_PREFIX|qos_profile_\w+|package|ParameterInput|TimeJumpDictionary|SendGoalKWargs"
    r"|type_support\.[A-Z][\w.]+|CallbackType(\.\w+)?|FutureState(\.\w+)?|Unpack|(CreateLifecyclePublisher|LifecycleNode)Args|Callbacks|ClockType|InvalidHandle|RCLError|PyCapsule"
    r"|(\w+Handle|DestroyableType)(\.\w+)?|DurationType"
    r"|InvalidParameterTypeException\.Parameter|(name|value|get_parameter_value|to_label))$"
)


# protocols and variables for type checkers
TYPES_ONLY = re.compile(
    r"\.(\w+Handle|DestroyableType|(TimeJump|TypeHash)Dictionary|DurationType|Action|Msg|Srv"
    r"|FeedbackMessage|\w+Service(Request|Response))$"
)


def public(python: str, *words: str, given: str = "") -> set[str]:
    command = [python, "-W", "ignore", "-m", "tests.ros2.public_names", *words]
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, check=False, input=given
    )
    assert done.returncode == 0, done.stderr
    return set(json.loads(done.stdout.splitlines()[-1]))


def test_every_public_name_is_there_or_in_the_list_of_the_page() -> None:
    real, ours = public(sys.executable), public(sys.executable, "embedded")
    missing = {name for name in real - ours if not USED.search(name)}
    parents = {name for name in missing if any(name.startswith(f"{m}.") for m in missing)}
    left = {
        name
        for name in missing - parents
        if not any(re.search(pattern, name) for pattern in NOT_EMULATED.values())
    }
    assert left == set(), "\n".join(sorted(left))
    page = (ROOT / "docs" / "embedded_engine.md").read_text(encoding="utf-8")
    section = " ".join(page.partition("## What it does not emulate")[2].split())
    for words, pattern in NOT_EMULATED.items():
        assert words in section, words
        if words != "content filters":  # which Jazzy's rclpy lacks
            assert any(re.search(pattern, name) for name in missing), f"{words} is emulated by now"


def test_what_a_module_only_imports_can_be_imported_from_there_or_is_named() -> None:
    real = {name for name in public(sys.executable, "reexported") if not TYPES_ONLY.search(name)}
    assert "rclpy.node.SetParametersResult" in real
    assert public(sys.executable, "imports", given=json.dumps(sorted(real))) == set()
