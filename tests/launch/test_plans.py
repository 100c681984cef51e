"""Launch files as tutorials have them, and what ROS 2 would start for each."""

from __future__ import annotations

import pytest

from tests.launch.planning import Launcher

NAMED = """
from launch import LaunchDescription
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([
        Node(package='my_robot', executable='talker', name='my_talker', output='screen'),
        Node(package='my_robot', executable='listener',
             remappings=[('chatter', '/robot/chatter'), ('a', 'b')],
             arguments=['--quiet', '--count', '3']),
    ])
"""
GROUPS = """\
GroupAction([
    PushRosNamespace('robot1'),
    SetParameter('use_sim_time', True),
    Node(package='my_robot', executable='talker', name='t', parameters=[{'rate': 3}]),
    GroupAction([
        PushRosNamespace('arm'), SetRemap('a', 'b'),
        Node(package='my_robot', executable='talker', namespace='left'),
        Node(package='my_robot', executable='talker', namespace='/top'),
    ]),
    GroupAction([PushRosNamespace('leg')], scoped=False),
    Node(package='my_robot', executable='listener'),
]),
Node(package='my_robot', executable='talker'),
"""
FILES = """\
Node(package='my_robot', executable='talker', parameters=[
    os.path.join(get_package_share_directory('my_robot'), 'config', 'params.yaml'),
]),
Node(package='my_robot', executable='talker', parameters=[
    PathJoinSubstitution([FindPackageShare('my_robot'), 'config', 'params.yaml']), {'rate': 4.0},
]),
"""
CONDITIONS = """\
DeclareLaunchArgument('use_sim', default_value='false', description='in simulation'),
Node(package='my_robot', executable='talker',
     condition=IfCondition(LaunchConfiguration('use_sim'))),
Node(package='my_robot', executable='listener',
     condition=UnlessCondition(LaunchConfiguration('use_sim'))),
"""
EXPRESSION = """\
DeclareLaunchArgument('mode', default_value='fast', choices=['fast', 'slow']),
Node(package='my_robot', executable='talker', parameters=[{'rate': PythonExpression(
    ["10 if '", LaunchConfiguration('mode'), "' == 'fast' else sqrt(4)"]
)}], condition=IfCondition(PythonExpression(
    ["'", LaunchConfiguration('mode'), "' in ('fast', 'slow')"]
))),
"""
INCLUDE = """
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument('hz', default_value='7.5'),
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource(
                PathJoinSubstitution([FindPackageShare('my_robot'), 'launch', 'talker.launch.py'])
            ),
            launch_arguments={'rate': LaunchConfiguration('hz')}.items(),
        ),
        Node(package='my_robot', executable='listener'),
    ])
"""
OPAQUE = """
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

def launch_setup(context, *args, **kwargs):
    count = int(LaunchConfiguration('count').perform(context))
    return [Node(package='my_robot', executable='talker', name=f'talker_{n}')
            for n in range(count)]

def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument('count', default_value='2'),
        OpaqueFunction(function=launch_setup),
    ])
"""
RESPAWN = """\
DeclareLaunchArgument('use_respawn', default_value='True'),
SetEnvironmentVariable('MODEL', 'burger'),
TimerAction(period=2.5, actions=[Node(package='my_robot', executable='listener')]),
Node(package='my_robot', executable='talker', respawn=LaunchConfiguration('use_respawn'),
     respawn_delay=2.0, output='both', additional_env={'LEVEL': '1'}),
"""
ROBOTS = """
from launch import LaunchDescription
from launch_ros.actions import Node

def generate_launch_description():
    ld = LaunchDescription()
    for number, name in enumerate(['alpha', 'beta']):
        ld.add_action(Node(
            package='my_robot', executable='talker', namespace=name, name='talker',
            parameters=[{'id': number, 'frame': f'{name}/base',
                         'pid': {'p': 1.0, 'limits': [0, 1.5]}}],
        ))
    return ld
"""
VALUES = """\
DeclareLaunchArgument('x', default_value='10'),
Node(package='my_robot', executable='talker', parameters=[{
    'typed': LaunchConfiguration('x'),
    'text': ParameterValue(LaunchConfiguration('x'), value_type=str),
    'number': ParameterValue(LaunchConfiguration('x'), value_type=float),
    'joined': [LaunchConfiguration('x'), '/base'],
    'list': ParameterValue(TextSubstitution(text='[1, 2]'), value_type=list[int]),
    'floats': ParameterValue([1, 2.0], value_type=list[float]),
    'each': [[LaunchConfiguration('x')], [LaunchConfiguration('x')]],
    'quoted': '10',
    'yes': TextSubstitution(text='yes'),
    'empty': EnvironmentVariable('SURELY_NOT_SET', default_value=''),
    'words': ['a', '1'],
}]),
Node(package='my_robot', executable='talker', parameters=[
    Parameter('rate', LaunchConfiguration('x'), value_type=float), Parameter('name', '5'),
]),
"""

CASES = {
    "two nodes": (
        NAMED,
        [],
        [
            "my_robot talker --ros-args -r __node:=my_talker",
            "my_robot listener --quiet --count 3 --ros-args -r chatter:=/robot/chatter -r a:=b",
        ],
    ),
    "groups": (
        GROUPS,
        [],
        [
            "my_robot talker --ros-args -r __node:=t -r __ns:=/robot1 -p use_sim_time:=True "
            "--params-file PREFIX/parameters/0_0.yaml",
            "my_robot talker --ros-args -r __ns:=/robot1/arm/left -p use_sim_time:=True -r a:=b",
            "my_robot talker --ros-args -r __ns:=/top -p use_sim_time:=True -r a:=b",
            "my_robot listener --ros-args -r __ns:=/robot1/leg -p use_sim_time:=True",
            "my_robot talker",
        ],
    ),
    "parameter files": (
        FILES,
        [],
        [
            "my_robot talker --ros-args --params-file PREFIX/share/my_robot/config/params.yaml",
            "my_robot talker --ros-args --params-file PREFIX/share/my_robot/config/params.yaml "
            "-p rate:=4.0",
        ],
    ),
    "a condition that does not hold": (CONDITIONS, [], ["my_robot listener"]),
    "a condition that holds": (CONDITIONS, ["use_sim:=True"], ["my_robot talker"]),
    "an expression": (EXPRESSION, [], ["my_robot talker --ros-args -p rate:=10"]),
    "an expression with math": (
        EXPRESSION,
        ["mode:=slow"],
        ["my_robot talker --ros-args -p rate:=2.0"],
    ),
    "an include": (
        INCLUDE,
        [],
        ["my_robot talker --ros-args -p rate:=7.5", "my_robot listener"],
    ),
    "a function": (
        OPAQUE,
        ["count:=1"],
        ["my_robot talker --ros-args -r __node:=talker_0"],
    ),
    "several robots": (
        ROBOTS,
        [],
        [
            f"my_robot talker --ros-args -r __node:=talker -r __ns:=/{name} "
            f"--params-file PREFIX/parameters/{number}_0.yaml"
            for number, name in enumerate(["alpha", "beta"])
        ],
    ),
    "values": (
        VALUES,
        [],
        [
            "my_robot talker --ros-args -p typed:=10 -p text:='10' -p number:=10.0 "
            "-p joined:=10/base -p list:=[1, 2] -p floats:=[1.0, 2.0] -p each:=[10, 10] "
            "-p quoted:='10' -p yes:=true -p empty:='' -p words:=[a, '1']",
            "my_robot talker --ros-args -p rate:=10.0 -p name:='5'",
        ],
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_a_launch_file_starts_what_it_starts_on_ros_2(launcher: Launcher, case: str) -> None:
    text, arguments, commands = CASES[case]
    if text.startswith("\n"):
        plan = launcher.plan(launcher.write(text), *arguments)
    else:
        plan = launcher.of_actions(text, *arguments)
    assert launcher.commands(plan) == commands
    assert plan.notes == []


def test_parameters_of_a_node_with_a_full_name_are_a_file_that_names_it(
    launcher: Launcher,
) -> None:
    plan = launcher.plan(launcher.write(ROBOTS))
    assert (launcher.prefix / "parameters" / "1_0.yaml").read_text(encoding="utf-8") == (
        "/beta/talker:\n  ros__parameters:\n    id: 1\n    frame: beta/base\n    pid.p: 1.0\n"
        "    pid.limits:\n    - 0.0\n    - 1.5\n"
    )
    assert [program.line for program in plan.programs] == [8, 8]


def test_respawn_environment_and_timers_are_told(launcher: Launcher) -> None:
    talker, listener = launcher.of_actions(RESPAWN).programs
    assert (talker.respawn, talker.respawn_delay) == (True, 2.0)
    assert talker.environment == {"MODEL": "burger", "LEVEL": "1"}
    assert (talker.start_delay, listener.start_delay) == (0.0, 2.5)
    assert listener.environment == {"MODEL": "burger"}
    assert listener.respawn is False
    assert listener.entry_point.module == "my_robot.listener"


def test_a_nodes_line_is_that_of_its_own_file(launcher: Launcher) -> None:
    plan = launcher.plan(launcher.write(INCLUDE))
    assert [(program.file.rpartition("/")[2], program.line) for program in plan.programs] == [
        ("talker.launch.py", 11),
        ("test.launch.py", 18),
    ]


def test_modules_of_the_workspaces_packages_can_be_imported(launcher: Launcher) -> None:
    plan = launcher.of_actions(
        "*[Node(package='my_robot', executable='talker', parameters=[{'hz': r}]) for r in RATES],",
        before="from my_robot.rates import RATES",
    )
    assert launcher.commands(plan) == [
        f"my_robot talker --ros-args -p hz:={rate}" for rate in (1, 2)
    ]


def test_modules_that_an_editor_imports_from_are_there(launcher: Launcher) -> None:
    code = """
        from launch.actions.execute_process import ExecuteProcess
        from launch.actions.set_environment_variable import SetEnvironmentVariable
        from launch.launch_description import LaunchDescription
        from launch.substitutions.launch_configuration import LaunchConfiguration
        from launch_ros.actions.node import Node

        def generate_launch_description():
            return LaunchDescription([Node(package='my_robot', executable='talker')])
    """
    assert launcher.commands(launcher.plan(launcher.write(code))) == ["my_robot talker"]


def test_timers_start_in_the_order_of_their_times(launcher: Launcher) -> None:
    plan = launcher.of_actions(
        """
        DeclareLaunchArgument('delay', default_value='2.0'),
        TimerAction(period=LaunchConfiguration('delay'), actions=[
            Node(package='my_robot', executable='talker', name='second'),
            TimerAction(period=1.0, actions=[Node(package='my_robot', executable='talker')]),
        ]),
        TimerAction(period=0.5, actions=[Node(package='my_robot', executable='listener')]),
        """
    )
    starts = [(program.executable, program.start_delay) for program in plan.programs]
    assert starts == [("listener", 0.5), ("talker", 2.0), ("talker", 3.0)]


# Each was compared with launch 3.7 and launch_ros.
# Each was compared with launch 3.7; n(...) is a talker of that name.
SMALL = {
    # Scopes.
    "GroupAction([SetLaunchConfiguration('x', 'in'), n(LaunchConfiguration('x'))]),"
    "n(LaunchConfiguration('x', default='out')),": "in out",
    "GroupAction([SetLaunchConfiguration('x', 'in')], scoped=False),"
    "n(LaunchConfiguration('x', default='out')),": "in",
    "SetLaunchConfiguration('x', 'out'), GroupAction(["
    "n(LaunchConfiguration('x', default='lost')), n(LaunchConfiguration('y'))],"
    "forwarding=False, launch_configurations={'y': LaunchConfiguration('x')}),": "lost out",
    "SetEnvironmentVariable('E', 'out'), GroupAction([SetEnvironmentVariable('E', 'in'), "
    "n(EnvironmentVariable('E'))]), n(EnvironmentVariable('E')),"
    "AppendEnvironmentVariable('E', 'er', separator='_'), n(EnvironmentVariable('E')),"
    "UnsetEnvironmentVariable('E'), n(EnvironmentVariable('E', default_value='gone')),": (
        "in out out_er gone"
    ),
    "GroupAction([IncludeLaunchDescription("
    "[FindPackageShare('my_robot'), '/launch/talker.launch.py'])]),"
    "n(['n', LaunchConfiguration('rate', default='one')]),": "none",
    # Arguments.
    "DeclareLaunchArgument('x', default_value='a'), DeclareLaunchArgument('x', default_value='b'),"
    "n(LaunchConfiguration('x')),": "a",
    # Conditions and booleans.
    "n('a', condition=IfCondition(' TRUE ')),": "a",
    "n('a', condition=UnlessCondition('0')),": "a",
    "n('a', condition=IfCondition(NotSubstitution('off'))),": "a",
    "n('a', condition=IfCondition(EqualsSubstitution('1', '1.0'))),": "a",
    "n('a', condition=IfCondition(AndSubstitution('on', 'no'))),": "",
    "n('a', condition=IfCondition(OrSubstitution('off', 'yes'))),": "a",
    "n('a', condition=LaunchConfigurationEquals('x', None)),": "a",
    "n('a', condition=LaunchConfigurationNotEquals('x', 'b')),": "a",
    "n(IfElseSubstitution('0', 'a', 'b')),": "b",
}


def test_scopes_arguments_and_conditions_are_those_of_launch(launcher: Launcher) -> None:
    for actions, names in SMALL.items():
        found = launcher.of_actions(actions).programs
        assert [program.name for program in found if program.name] == names.split(), actions


def test_a_namespace_is_relative_to_those_around_unless_it_begins_with_a_slash(
    launcher: Launcher,
) -> None:
    plan = launcher.of_actions(
        """
        PushRosNamespace('a'), PushRosNamespace('b'),
        *[Node(package='my_robot', executable='talker', namespace=name)
          for name in (None, 'c', '/', '/d/', '', 'e/f/')],
        """
    )
    spaces = [program.namespace for program in plan.programs]
    assert spaces == ["/a/b", "/a/b/c", "/", "/d", "/a/b", "/a/b/e/f"]
