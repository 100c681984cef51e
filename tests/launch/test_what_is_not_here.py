"""What cannot be done without ROS 2 is left out, in one line each; the rest is started."""

from __future__ import annotations

from tests.launch.planning import WORKSPACE, Launcher

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
