"""What ROS 2 would not run, or what needs it, is one line each; the rest is started."""

from __future__ import annotations

import os
import select
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from archo_tui.base.errors import ArchoError
from archo_tui.ros import release as ros_release
from archo_tui.user_code.ros_launch.evaluate import LaunchFileError, evaluate, parse_arguments
from archo_tui.user_code.ros_launch.workspace import Workspace
from tests.launch.planning import WORKSPACE, Launcher, in_this_process
from tests.support.waiting import DEADLINE

WRONG = {
    "Node(package='my_robot', executable='talker', name=LaunchConfiguration('nam')),": (
        "21: no launch configuration nam: declare it before, DeclareLaunchArgument('nam')"
    ),
    "DeclareLaunchArgument('rate', description='in Hz'),": (
        "21: argument rate (in Hz) has no value: give rate:=VALUE"
    ),
    "DeclareLaunchArgument('mode', choices=['fast', 'slow'], default_value=['fas', 't', 'e']),": (
        "21: argument mode is 'faste': one of fast, slow is wanted (nearest: fast)"
    ),
    "Node(package='my_robot', executable='talker', condition=IfCondition('yes')),": (
        "21: a condition is 'yes': true, 1, false or 0 is wanted"
    ),
    "Node(package='my_robot', executable='talker', parameters={'rate': 1}),": (
        "21: TypeError: parameters is a list: parameters=[...], not dict, "
        "in: Node(package='my_robot', executable='talker', parameters={'rate': 1}),"
    ),
    "Node(package='my_robot', node_executable='talker', executable='talker'),": (
        "21: TypeError: Node.__init__() got an unexpected keyword argument 'node_executable', "
        "in: Node(package='my_robot', node_executable='talker', executable='talker'),"
    ),
    "Node(package='my_robot', executable='talker', parameters=[{'frames': []}]),": (
        "21: TypeError: parameter frames: the list [] is empty, so its type is not known"
    ),
    "Node(package='my_robot', executable='talker', "
    "parameters=[{'rate': ParameterValue('5', value_type=int)}]),": "21: '5' is not of type int",
    "LogInfo(msg=PythonExpression('fast == 1')),": (
        "21: PythonExpression fast == 1: NameError: name 'fast' is not defined: a text needs "
        'quotes in it, ["\'", LaunchConfiguration(...), "\'"]'
    ),
    "LogInfo(msg=EnvironmentVariable('SURELY_NOT_SET')),": (
        "21: no environment variable SURELY_NOT_SET: export it, or give EnvironmentVariable a "
        "default_value"
    ),
    "IncludeLaunchDescription([FindPackageShare('my_robot'), '/launch/no.launch.py']),": (
        "21: my_robot has no launch/no.launch.py"
    ),
    "IncludeLaunchDescription('a.launch.py', launch_arguments={'a': 'b'}),": (
        "21: TypeError: launch_arguments is a mapping: write {...}.items(), "
        "in: IncludeLaunchDescription('a.launch.py', launch_arguments={'a': 'b'}),"
    ),
    "DeclareLaunchArgument('use_sim', default_value=True),": (
        "21: TypeError: a text or a substitution is wanted, not bool True: write 'true', "
        "in: DeclareLaunchArgument('use_sim', default_value=True),"
    ),
    "None,": "14: an action is wanted, not a NoneType: None",
}
FILES = {
    "x = 1": "1: it has no function generate_launch_description()",
    "def generate_launch_description():\n    pass": (
        "1: generate_launch_description() returns no LaunchDescription: end it with "
        "return LaunchDescription([...])"
    ),
    "import os\nos.nope()": (
        "2: AttributeError: module 'os' has no attribute 'nope', in: os.nope()"
    ),
    "def f(:\n": "1: SyntaxError: invalid syntax, in: def f(:",
    "from launch_ros.substitutions import FindPackageShare\n"
    "open(FindPackageShare('nav2').find('nav2') + '/a.urdf')": (
        "2: package nav2 is not here, nor its files"
    ),
    "import my_helpers": (
        "1: ModuleNotFoundError: No module named 'my_helpers' (looked for it where Python looks, "
        "and in the packages of the workspace), in: import my_helpers"
    ),
    "from launch.actions import Nothing": (
        "1: ImportError: cannot import name 'Nothing' from 'launch.actions'"
    ),
}


def test_a_wrong_action_is_one_line_with_its_place(launcher: Launcher) -> None:
    for action, text in WRONG.items():
        with pytest.raises(LaunchFileError) as raised:
            launcher.of_actions(action)
        assert str(raised.value) == f"{launcher.file}:{text}"


def test_a_wrong_file_is_one_line_with_its_place(launcher: Launcher) -> None:
    for code, text in FILES.items():
        with pytest.raises(LaunchFileError) as raised:
            launcher.plan(launcher.write(code))
        assert str(raised.value).startswith(f"{launcher.file}:{text}")


def test_the_traceback_is_there_on_request_and_has_the_persons_lines_only(
    launcher: Launcher,
) -> None:
    code = "def rate():\n    return 1 / 0\n\ndef generate_launch_description():\n    rate()\n"
    with pytest.raises(LaunchFileError) as raised:
        launcher.plan(launcher.write(code))
    report = raised.value.report
    assert report.splitlines()[0] == "Traceback (most recent call last):"
    assert report.count("test.launch.py") == report.count("  File ") == 2
    assert report.splitlines()[-1] == "ZeroDivisionError: division by zero"


def test_an_include_without_a_value_for_its_argument_names_the_include(launcher: Launcher) -> None:
    launcher.write("<launch>\n<arg name='robot'/>\n</launch>", "inner.launch.xml")
    include = f"IncludeLaunchDescription('{launcher.folder.as_posix()}/inner.launch.xml'"
    with pytest.raises(LaunchFileError) as raised:
        launcher.of_actions(f"{include}),")
    assert "inner.launch.xml:2: argument robot has no value" in str(raised.value)
    assert launcher.of_actions(f"{include}, launch_arguments=[('robot', 'a')]),").notes == []


def test_the_release_of_the_engine_is_in_the_environment(
    launcher: Launcher, monkeypatch: pytest.MonkeyPatch, workspace: Workspace
) -> None:
    monkeypatch.delenv("ROS_DISTRO", raising=False)
    text = "<launch><log message='$(env ROS_DISTRO)'/></launch>"
    file = str(launcher.write(text, "release.launch.xml"))
    plan = evaluate(file, workspace, launcher.prefix, {})
    assert [note.text for note in plan.notes] == [ros_release.distribution() or "kilted"]
    assert "ROS_DISTRO" not in plan.environment


def test_a_mistake_in_setup_is_told_where_the_share_folder_is_needed(
    launcher: Launcher, tmp_path: Path
) -> None:
    package = shutil.copytree(WORKSPACE / "src" / "my_robot", tmp_path / "my_robot")
    (package / "setup.py").write_text("import nothing", encoding="utf-8")
    launcher = Launcher(tmp_path, Workspace.below(tmp_path), tmp_path / "prefix")
    with pytest.raises(LaunchFileError) as raised:
        launcher.of_actions("LogInfo(msg=get_package_share_directory('my_robot')),")
    mistake = f"{launcher.file}:21: {package}{os.sep}setup.py:1: ModuleNotFoundError: No module"
    assert str(raised.value).startswith(mistake)


def test_words_that_are_no_arguments_are_refused() -> None:
    assert parse_arguments(["a:=1", "b:=", "a:=2:=3"]) == {"a": "2:=3", "b": ""}
    with pytest.raises(ArchoError, match="use_sim=true: an argument of a launch file is written"):
        parse_arguments(["use_sim=true"])


def test_arguments_are_listed_without_performing_anything(
    launcher: Launcher, workspace: Workspace
) -> None:
    path = launcher.describing(
        """
        DeclareLaunchArgument('robot', description='its name'),
        DeclareLaunchArgument('mode', default_value='fast', choices=['fast', 'slow']),
        DeclareLaunchArgument('ns', default_value=['/', LaunchConfiguration('robot')]),
        GroupAction([DeclareLaunchArgument('extra')], condition=IfCondition('false')),
        TimerAction(period=1.0, actions=[DeclareLaunchArgument('late')]),
        LogInfo(msg=LaunchConfiguration('nowhere')),
        """
    )
    with in_this_process():
        found = evaluate(str(path), workspace, launcher.prefix, None).arguments
    assert [(one.name, one.default, one.choices, one.is_conditional) for one in found] == [
        ("robot", None, [], False),
        ("mode", "fast", ["fast", "slow"], False),
        ("ns", "/LaunchConfiguration(robot)", [], False),
        ("extra", None, [], True),
        ("late", None, [], False),
    ]
    assert found[0].description == "its name"


HANGS = """
import time
def generate_launch_description():
    while True:
        time.sleep(0.01)
"""
FLOODS = """
import os, subprocess, sys
from launch import LaunchDescription
print('first line')
for _ in range(30):
    os.write(1, b'x' * 65_536)
sys.stderr.write('y' * 100_000)
subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(60)'], stdout=open('{fifo}', 'w'))
def generate_launch_description():
    print(sys.stdin.read())
    return LaunchDescription([])
"""


@pytest.mark.real_time
def test_a_hang_ends_and_names_its_line(launcher: Launcher, workspace: Workspace) -> None:
    path = launcher.write(HANGS)
    with pytest.raises(LaunchFileError) as raised:
        evaluate(str(path), workspace, launcher.prefix, {}, 0.3)
    said = str(raised.value).partition(", in: ")[0]
    ends = [f"{launcher.file}:{line}: does not return within 0.3 s" for line in (4, 5)]
    assert said in ends


@pytest.mark.real_time
@pytest.mark.posix
def test_a_flood_of_output_holds_up_nothing_and_what_was_started_is_ended(
    launcher: Launcher, workspace: Workspace
) -> None:
    fifo = launcher.folder / "fifo"
    os.mkfifo(fifo)
    held = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    path = launcher.write(FLOODS.replace("{fifo}", str(fifo)))
    plan = evaluate(str(path), workspace, launcher.prefix, {})
    assert plan.programs == []
    assert 100_000 <= len(plan.printed) <= 100_001
    # The other end is closed when the last process that holds it has ended.
    assert select.select([held], [], [], DEADLINE)[0] == [held]
    assert os.read(held, 1) == b""
    os.close(held)


@pytest.mark.real_time
def test_a_file_that_ends_its_process_is_told(launcher: Launcher, workspace: Workspace) -> None:
    path = launcher.write("import os\nos._exit(7)")
    with pytest.raises(LaunchFileError, match="it ended Python, exit code 7"):
        evaluate(str(path), workspace, launcher.prefix, {})


def test_code_that_hangs_ends_in_time_though_who_asked_was_killed() -> None:
    code = (
        "from archo_tui.user_code.ros_launch.child_process import serve\n"
        "serve(lambda _: exec('while True: pass'), lambda _: False)"
    )
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    with subprocess.Popen([sys.executable, "-c", code], **pipes) as child:  # type: ignore[call-overload]
        child.stdout.close()
        child.stderr.close()
        child.stdin.write(b'{"seconds": 0.2, "request": null}')
        child.stdin.close()
        try:
            assert child.wait(DEADLINE) == 0
        finally:
            child.kill()


TALKER = "Node(package='my_robot', executable='talker')"

REFUSED = {
    "ExecuteProcess(cmd=['ros2', 'bag', 'record'])": (
        "ExecuteProcess does not run here, nor what needs it: ROS 2 runs it"
    ),
    "Node(executable='/bin/true')": (
        "a Node without package runs /bin/true, which is not started here"
    ),
    "Node(package='rviz2', executable='rviz2')": ("package rviz2 is not here: start it with ROS 2"),
    "Node(package='my_robbot', executable='talker')": (
        "package my_robbot is not here (nearest: my_robot)"
    ),
    "Node(package='my_cpp', executable='driver')": (
        "my_cpp is an ament_cmake package, of which only scripts that install(PROGRAMS) names "
        "run here: build it and start driver with ROS 2"
    ),
    "Node(package='my_robot', executable='talkr')": (
        "my_robot has no executable talkr (nearest: talker): see console_scripts in its setup.py"
    ),
    "Node(package='my_robot', executable='x')": (
        "my_robot has no executable x (it has talker, listener, lost): see console_scripts in its "
        "setup.py"
    ),
    "Node(package='my_robot', executable='lost')": (
        f"lost in setup.py of my_robot: there is no Python file {WORKSPACE.resolve()}/src/my_robot/"
        "my_robot/listner.py (nearest: listener)"
    ),
    "IncludeLaunchDescription(os.path.join(get_package_share_directory('nav2'), 'a.launch.py'))": (
        "nav2 is not here: start its a.launch.py with ROS 2"
    ),
    "Node(package='my_robot', executable='talker', parameters=[{'model': Command('xacro a')}])": (
        "Command does not run here, nor what needs it: ROS 2 runs it"
    ),
}


def test_what_is_not_here_is_one_line_and_the_rest_starts(launcher: Launcher) -> None:
    for action, text in REFUSED.items():
        plan = launcher.of_actions(f"{action},\n{TALKER},")
        assert [(note.where, note.text) for note in plan.notes] == [(f"{launcher.file}:21", text)]
        assert launcher.commands(plan) == ["my_robot talker"]


def test_an_argument_that_is_not_here_leaves_its_include_in_place(launcher: Launcher) -> None:
    plan = launcher.of_actions(
        """
        IncludeLaunchDescription(
            [FindPackageShare('my_robot'), '/launch/talker.launch.py'],
            launch_arguments=[('rate', '3'), ('model', Command('xacro a'))],
        ),
        """
    )
    assert [note.text.partition(" ")[0] for note in plan.notes] == ["Command"]
    assert launcher.commands(plan) == ["my_robot talker --ros-args -p rate:=3"]


def test_a_launch_file_may_ask_which_packages_are_there(launcher: Launcher) -> None:
    plan = launcher.of_actions(
        """
        *[Node(package=name, executable='talker')
          for name in ('my_robot', 'camera_ros') if has_resource('packages', name)],
        *[Node(package=name, executable='listener')
          for name in ('my_robot', 'nav2') if name in get_packages_with_prefixes()],
        """,
        before="from ament_index_python.resources import has_resource\n"
        "from ament_index_python.packages import get_packages_with_prefixes",
    )
    assert launcher.commands(plan) == ["my_robot talker", "my_robot listener"]


def test_what_a_condition_leaves_out_is_not_told(launcher: Launcher) -> None:
    plan = launcher.of_actions("ExecuteProcess(cmd=[], condition=IfCondition('false')),")
    assert plan.notes == []
    assert plan.programs == []


def test_a_parameter_file_that_setup_forgets_is_told_and_the_node_starts(
    launcher: Launcher,
) -> None:
    plan = launcher.of_actions(
        """
        Node(
            package='my_robot', executable='talker',
            parameters=[
                os.path.join(get_package_share_directory('my_robot'), 'config', name)
                for name in ('forgotten.yaml', 'params.yml', 'params.yaml')
            ],
        )
        """
    )
    assert [note.text for note in plan.notes] == [
        "parameter file forgotten.yaml is left out: setup.py of my_robot does not install "
        "config/forgotten.yaml: name it in data_files",
        "parameter file params.yml is left out: my_robot has no config/params.yml",
    ]
    assert launcher.commands(plan) == [
        "my_robot talker --ros-args --params-file PREFIX/share/my_robot/config/params.yaml"
    ]


def test_an_argument_that_the_file_does_not_have_is_told(launcher: Launcher) -> None:
    plan = launcher.of_actions("DeclareLaunchArgument('use_sim', default_value='1'),", "usesim:=1")
    assert [str(note) for note in plan.notes] == [
        f"{launcher.file}: usesim:=1: this launch file has no argument usesim (nearest: use_sim)"
    ]


def test_a_package_that_only_its_folder_was_asked_of_is_told(launcher: Launcher) -> None:
    text = f"{TALKER} if get_package_share_directory('my_robott') else None,"
    assert [note.text for note in launcher.of_actions(text).notes] == [
        "package my_robott is not here (nearest: my_robot): its folder has no files"
    ]


def test_the_launch_file_of_a_package_in_cpp_is_included(launcher: Launcher) -> None:
    plan = launcher.of_actions(
        "IncludeLaunchDescription([FindPackageShare('my_cpp'), '/launch/driver.launch.py']),"
    )
    [note] = plan.notes
    assert note.where == "driver.launch.py:6"
    assert "start driver with ROS 2" in note.text


def test_xacro_and_other_packages_are_left_out_where_they_are_needed(launcher: Launcher) -> None:
    plan = launcher.of_actions(
        """
        Node(package='my_robot', executable='talker', parameters=[{'robot_description': model}]),
        Node(package='my_robot', executable='listener'),
        """,
        before="import xacro\nmodel = xacro.process_file('robot.urdf.xacro').toxml()",
    )
    assert [note.text for note in plan.notes] == [
        "process_file does not run here, nor what needs it: ROS 2 runs it (line 22)"
    ]
    assert launcher.commands(plan) == ["my_robot listener"]


def test_what_a_launch_file_says_is_information(launcher: Launcher) -> None:
    plan = launcher.of_actions("LogInfo(msg=['in ', ThisLaunchFileDir()]),")
    assert [(note.level, note.text) for note in plan.notes] == [("INFO", f"in {launcher.folder}")]
