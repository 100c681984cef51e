"""The launch file, as far as it goes without ROS's launch packages: stand-ins record its words."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

pytestmark = pytest.mark.pure

LAUNCH = Path(__file__).parent.parent.parent / "nodes" / "launch" / "archo_comms.launch.py"


def stand_in(monkeypatch: pytest.MonkeyPatch, name: str, **members: Any) -> None:
    module = ModuleType(name)
    module.__dict__.update(members)
    monkeypatch.setitem(sys.modules, name, module)


def record(**fixed: Any) -> Any:
    return lambda *args, **options: SimpleNamespace(args=args, **fixed, **options)


def test_it_starts_three_nodes_and_the_drain_on_demand(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "config").mkdir()
    (tmp_path / "config" / "motor_params.yaml").touch()
    stand_in(
        monkeypatch,
        "ament_index_python.packages",
        get_package_share_directory=lambda package: str(tmp_path),
    )
    stand_in(monkeypatch, "ament_index_python")
    stand_in(monkeypatch, "launch", LaunchDescription=lambda entities: entities)
    stand_in(monkeypatch, "launch.actions", DeclareLaunchArgument=record(kind="argument"))
    stand_in(monkeypatch, "launch.conditions", IfCondition=record(kind="if"))
    stand_in(monkeypatch, "launch.substitutions", LaunchConfiguration=record(kind="value"))
    stand_in(monkeypatch, "launch_ros")
    stand_in(monkeypatch, "launch_ros.actions", Node=record(kind="node"))
    spec = importlib.util.spec_from_file_location("archo_comms", LAUNCH)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)

    argument, *nodes = module.generate_launch_description()
    assert (argument.args, argument.default_value) == (("use_sim",), "false")
    assert [node.executable for node in nodes] == [
        "battery_monitor",
        "dashboard",
        "motor_controller",
        "fake_battery_drain",
    ]
    for node in nodes:
        assert node.package == "archo_bringup"
        assert node.parameters == [str(tmp_path / "config" / "motor_params.yaml")]
        assert importlib.util.find_spec(f"archo_bringup.{node.executable}") is not None
    assert [hasattr(node, "condition") for node in nodes] == [False, False, False, True]
    assert nodes[3].condition.args[0].args == ("use_sim",)
