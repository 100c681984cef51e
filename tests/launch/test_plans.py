"""Launch files in Python, XML and YAML, and what ROS 2 would start for each."""

from __future__ import annotations

from html import escape

import pytest

from archo_tui.user_code.ros_launch.evaluate import LaunchFileError
from archo_tui.user_code.ros_launch.plan import LaunchPlan
from tests.launch.planning import Launcher

NAMED = """\
Node(package='my_robot', executable='talker', name='my_talker', output='screen'),
Node(package='my_robot', executable='listener',
     remappings=[('chatter', '/robot/chatter'), ('a', 'b')],
     arguments=['--quiet', '--count', '3']),
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
INCLUDE = """\
DeclareLaunchArgument('hz', default_value='7.5'),
IncludeLaunchDescription(
    PythonLaunchDescriptionSource(
        PathJoinSubstitution([FindPackageShare('my_robot'), 'launch', 'talker.launch.py'])
    ),
    launch_arguments={'rate': LaunchConfiguration('hz')}.items(),
),
Node(package='my_robot', executable='listener'),
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


def test_parameters_of_a_node_with_a_full_name_are_a_file_that_names_it(launcher: Launcher) -> None:
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
    plan = launcher.of_actions(INCLUDE)
    assert [(program.file.rpartition("/")[2], program.line) for program in plan.programs] == [
        ("talker.launch.py", 11),
        ("test.launch.py", 28),
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
    "n('a', condition=IfCondition(NotSubstitution('off'))),": "a",
    "n('a', condition=IfCondition(EqualsSubstitution('1', '1.0'))),": "a",
    "n('a', condition=IfCondition(AndSubstitution('on', 'no'))),": "",
    "n('a', condition=LaunchConfigurationEquals('x', None)),": "a",
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


XML = """<launch>
  <arg name="robot" default="r1" description="its name"/>
  <arg name="sim" default="false"/>
  <let name="hz" value="7.5"/>
  <set_env name="MODEL" value="$(var robot)_x"/>
  <node pkg="my_robot" exec="talker" name="$(var robot)_talker" output="screen"
        args="--quiet --count 3 $(var hz)" respawn="true" respawn_delay="2.0">
    <param name="rate" value="$(var hz)"/>
    <param name="pid"><param name="p" value="1.0"/></param>
    <param name="names" value="[a, b]" type="list_of_str"/>
    <param from="$(find-pkg-share my_robot)/config/params.yaml"/>
    <remap from="chatter" to="/$(var robot)/chatter"/>
    <env name="LEVEL" value="1"/>
  </node>
  <group if="$(var sim)"><node pkg="my_robot" exec="listener"/></group>
  <group unless="$(var sim)">
    <push-ros-namespace namespace="sub"/>
    <node pkg="my_robot" exec="listener"/>
  </group>
  <include file="$(find-pkg-share my_robot)/launch/talker.launch.py">
    <arg name="rate" value="$(eval '2 * $(var hz)')"/>
  </include>
  <timer period="2"><node pkg="my_robot" exec="talker"/></timer>
  <log message="in $(dirname)"/>
  <executable cmd="ls -l"/>
</launch>"""
YAML = """launch:
- arg: {name: robot, default: r1, description: its name}
- arg: {name: sim, default: "false"}
- let: {name: hz, value: "7.5"}
- set_env: {name: MODEL, value: $(var robot)_x}
- node:
    pkg: my_robot
    exec: talker
    name: $(var robot)_talker
    output: screen
    args: --quiet --count 3 $(var hz)
    respawn: "true"
    respawn_delay: 2.0
    param:
    - {name: rate, value: $(var hz)}
    - name: pid
      param: [{name: p, value: 1.0}]
    - {name: names, value: [a, b]}
    - {from: $(find-pkg-share my_robot)/config/params.yaml}
    remap: [{from: chatter, to: /$(var robot)/chatter}]
    env: [{name: LEVEL, value: "1"}]
- group:
    if: $(var sim)
    children: [{node: {pkg: my_robot, exec: listener}}]
- group:
    unless: $(var sim)
    children:
    - push_ros_namespace: {namespace: sub}
    - node: {pkg: my_robot, exec: listener}
- include:
    file: $(find-pkg-share my_robot)/launch/talker.launch.py
    arg: [{name: rate, value: $(eval '2 * $(var hz)')}]
- timer: {period: 2.0, children: [{node: {pkg: my_robot, exec: talker}}]}
- log: {message: in $(dirname)}
- executable: {cmd: ls -l}
"""


def plan_of(launcher: Launcher, text: str, *arguments: str) -> LaunchPlan:
    ending = "xml" if text.startswith("<") else "yaml"
    return launcher.plan(launcher.write(text, f"test.launch.{ending}"), *arguments)


def error_of(launcher: Launcher, text: str) -> str:
    with pytest.raises(LaunchFileError) as raised:
        plan_of(launcher, text)
    return str(raised.value).removeprefix(f"{launcher.folder}/test.launch.")


@pytest.mark.parametrize(("text", "line"), [(XML, 6), (YAML, 6)])
def test_xml_and_yaml_start_what_python_starts(launcher: Launcher, text: str, line: int) -> None:
    plan = plan_of(launcher, text)
    assert launcher.commands(plan) == [
        "my_robot talker --quiet --count 3 7.5 --ros-args -r __node:=r1_talker -p rate:=7.5 "
        "-p pid.p:=1.0 -p names:=[a, b] --params-file PREFIX/share/my_robot/config/params.yaml "
        "-r chatter:=/r1/chatter",
        "my_robot listener --ros-args -r __ns:=/sub",
        "my_robot talker --ros-args -p rate:=15.0",
        "my_robot talker",
    ]
    first, *_, last = plan.programs
    assert (first.line, first.respawn, first.respawn_delay) == (line, True, 2.0)
    assert first.environment == {"MODEL": "r1_x", "LEVEL": "1"}
    assert last.start_delay == 2.0
    said, left_out = plan.notes
    assert said.text.endswith("/share/my_robot/launch")  # Of the file that was included last.
    assert left_out.text.startswith("executable does not run here")
    assert [(one.name, one.default, one.description) for one in plan.arguments[:2]] == [
        ("robot", "r1", "its name"),
        ("sim", "false", ""),
    ]


def test_python_includes_xml_and_yaml(launcher: Launcher) -> None:
    include = '<launch><arg name="n"/><node pkg="my_robot" exec="talker" name="$(var n)"/></launch>'
    launcher.write(include, "inner.launch.xml")
    launcher.write("launch: [{node: {pkg: my_robot, exec: listener}}]", "inner.launch.yaml")
    folder = launcher.folder.as_posix()
    plan = launcher.of_actions(
        f"""
        IncludeLaunchDescription(AnyLaunchDescriptionSource('{folder}/inner.launch.xml'),
                                 launch_arguments=[('n', 'a')]),
        IncludeLaunchDescription('{folder}/inner.launch.yaml'),
        """
    )
    assert launcher.commands(plan) == [
        "my_robot talker --ros-args -r __node:=a",
        "my_robot listener",
    ]
    assert {"inner.launch.xml", "inner.launch.yaml"} <= {path.split("/")[-1] for path in plan.files}
    with pytest.raises(LaunchFileError, match=r"inner\.launch\.xml:1: SyntaxError"):
        launcher.of_actions(
            f"IncludeLaunchDescription(PythonLaunchDescriptionSource('{folder}/inner.launch.xml')),"
        )


TEXTS = {
    "plain $ text": "plain $ text",
    r"a\$(b": "a$(b",
    "$$(var x)": "$v",
    "pre$(var x)post": "prevpost",
    "$(var $(var p))": "v",
    "$(var y z)": "z",
    r"$(env NOPE 'it\'s')": "it's",
    "$(env NOPE 'a(b)')": "a(b)",
    r"$(env NOPE a\(b\))": "a(b)",
    "$(eval '1 + 1')": "2",
    "$(eval \"'$(var x)' == 'v'\")": "True",
    "$(eval 'os.sep' 'math, os')": "/",
    "$(not true)": "false",
    "$(and true 1)": "true",
    "$(if 0 a b)": "b",
    "": "",
}
WRONG_TEXTS = {
    "$(var  x)": "one blank is wanted between its words",
    "$(var x": "a blank or ) is wanted before '', or quotes",
    "$(vra x)": "there is no such substitution (nearest: var)",
    "$(var)": "it is written $(var VARIABLE_NAME DEFAULT)",
    "$(eval 1 + 1)": "it is written $(eval EXPRESSION PYTHON_MODULES)",
    "$(env NOPE a(b))": "a blank or ) is wanted before '(b))', or quotes",
    "$(env NOPE 'ab)": "its ' is not closed",
}


def logging(text: str) -> str:
    begin = '<launch><arg name="x" default="v"/><arg name="p" default="x"/>'
    return f'{begin}<log message="{escape(text)}"/></launch>'


def test_a_substitution_in_a_text_is_what_it_is_in_launch(launcher: Launcher) -> None:
    for text, said in TEXTS.items():
        assert [note.text for note in plan_of(launcher, logging(text)).notes] == [said], text


def test_a_file_is_read_into_a_text(launcher: Launcher) -> None:
    launcher.write("<robot/>", "robot.urdf")
    text = logging("$(file-content '$(dirname)/robot.urdf')")
    assert [note.text for note in plan_of(launcher, text).notes] == ["<robot/>"]
    assert error_of(launcher, logging("$(file-content no.urdf)")).endswith(
        "No such file or directory"
    )


def test_a_wrong_substitution_is_quoted_with_what_is_wanted(launcher: Launcher) -> None:
    for text, why in WRONG_TEXTS.items():
        assert error_of(launcher, logging(text)) == f"xml:1: {text}: {why}"


PARAMETER_VALUES = {
    'value="1"': "1",
    'value="yes"': "true",
    'value="[1, 2]"': "[1, 2]",
    "value=\"['$(env NOPE a)', b]\"": "[a, b]",
    'value="1" type="str"': "'1'",
    'value="1" type="float"': "1.0",
    'value="$(eval 2)" type="str"': "'2'",
}
WRONG = {
    '<launch><node pkg="my_robot"/></launch>': "xml:1: node has no exec",
    '<launch>\n<node pk="my_robot" exec="talker"/></launch>': (
        "xml:2: node takes no pk (nearest: pkg)"
    ),
    '<launch><node pkg="my_robot" exec="talker" if="1" unless="1"/></launch>': (
        "xml:1: node has if and unless: give one"
    ),
    '<launch>\n\n<nod pkg="my_robot"/></launch>': ("xml:3: there is no action nod (nearest: node)"),
    "<launch": "xml:1: not XML: unclosed token",
    "<robot/>": "xml:1: it begins with robot, not launch",
    '<!DOCTYPE l [<!ENTITY a "b">]><launch><log message="&a;"/></launch>': (
        "xml:1: entities (&a;) are not read: write it out"
    ),
    "launch:\n- node: {pkg: my_robot, exec: talker, respawn: true}": (
        'yaml:2: respawn of node: a text is wanted: "true"'
    ),
    "launch:\n- node: {pkg: my_robot, exec: talker, param: {name: a, value: 1}}": (
        "yaml:2: param of node: a list is wanted, as `param: [{...}]`"
    ),
    "launch:\n- log: {message: a}\n  arg: {name: x}": (
        "yaml:2: each entry is one action, as `- node:`"
    ),
    "a: [": "yaml:1: not YAML: expected the node content, but found '<stream end>'",
}


def test_the_value_of_a_parameter_has_the_type_that_it_has_in_launch(launcher: Launcher) -> None:
    for attributes, value in PARAMETER_VALUES.items():
        node = f'<node pkg="my_robot" exec="talker"><param name="a" {attributes}/></node>'
        found = launcher.commands(plan_of(launcher, f"<launch>{node}</launch>"))
        assert found == [f"my_robot talker --ros-args -p a:={value}"], attributes


def test_a_mistake_is_one_line_with_its_place(launcher: Launcher) -> None:
    for text, said in WRONG.items():
        assert error_of(launcher, text) == said


def test_a_file_that_is_too_large_says_so(launcher: Launcher) -> None:
    for name in ("test.launch.yaml", "test.launch.xml"):
        path = launcher.write(f"<!--{'x' * 1_100_000}--><launch/>", name)
        with pytest.raises(LaunchFileError, match="larger than"):
            launcher.plan(path)


def test_the_words_of_a_command_line_are_split_as_a_shell_does(launcher: Launcher) -> None:
    for args, words in {
        "a b  'c d'": ["a", "b", "c d"],
        "a$(var x)b c": ["avb", "c"],
        "$(var x) $(var x)": ["v", "v"],
        " $(var x)$(var x)": ["vv"],
    }.items():
        node = f'<node pkg="my_robot" exec="talker" args="{args}"/>'
        text = f'<launch><arg name="x" default="v"/>{node}</launch>'
        assert list(plan_of(launcher, text).programs[0].arguments) == words


@pytest.mark.parametrize("ending", ["xml", "yaml"])
def test_files_that_include_each_other_without_end_are_told(
    launcher: Launcher, ending: str
) -> None:
    def including(name: str) -> str:
        file = f"$(dirname)/{name}.launch.{ending}"
        if ending == "yaml":
            return f"launch:\n- include: {{file: {file}}}\n"
        return f'<launch>\n<include file="{file}"/>\n</launch>'

    for name, other in (("one", "two"), ("two", "one")):
        path = launcher.write(including(other), f"{name}.launch.{ending}")
    with pytest.raises(LaunchFileError, match=":2: these launch files include each other without"):
        launcher.plan(path)


def test_a_file_may_include_itself_while_a_condition_holds(launcher: Launcher) -> None:
    path = launcher.write(
        """\
        <launch>
          <arg name="count" default="3"/>
          <node pkg="my_robot" exec="talker" name="talker_$(var count)"/>
          <include file="$(filename)" if="$(eval '$(var count) &gt; 1')">
            <arg name="count" value="$(eval '$(var count) - 1')"/>
          </include>
        </launch>
        """,
        "self.launch.xml",
    )
    names = [program.name for program in launcher.plan(path).programs]
    assert names == ["talker_3", "talker_2", "talker_1"]
