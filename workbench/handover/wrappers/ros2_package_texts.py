"""The texts that make a folder a package of ROS 2: its manifest, build, plug-in and introduction."""

from string import Template

PACKAGE = Template("""<?xml version="1.0"?>
<?xml-model href="http://download.ros.org/schema/package_format3.xsd" schematypens="http://www.w3.org/2001/XMLSchema"?>
<!-- Made by $mark. -->
<package format="3">
  <name>$package</name>
  <version>0.0.1</version>
  <description>$title: a control law as a controller of ros2_control.</description>
  <maintainer email="nobody@example.com">nobody</maintainer>
  <license>to be named</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
$depends
  <export>
    <build_type>ament_cmake</build_type>
  </export>
</package>
""")

BUILD = Template("""# Made by $mark.
cmake_minimum_required(VERSION 3.16)
project($package C CXX)

set(CMAKE_C_STANDARD 99)
set(CMAKE_CXX_STANDARD 17)

find_package(ament_cmake REQUIRED)
$finds

add_library($package SHARED src/${name}_controller.cpp src/$name.c)
target_include_directories($package PRIVATE include src)
# The bits need each product and each sum rounded by itself.
set_source_files_properties(src/$name.c PROPERTIES COMPILE_OPTIONS "-ffp-contract=off")
ament_target_dependencies($package $depends)

pluginlib_export_plugin_description_file(controller_interface ${name}_controller.xml)
install(TARGETS $package LIBRARY DESTINATION lib)
ament_package()
""")

PLUGIN = Template("""<!-- Made by $mark. -->
<library path="$package">
  <class name="$package/Controller" type="$package::Controller"
    base_class_type="controller_interface::ControllerInterface">
    <description>$title</description>
  </class>
</library>
""")

README = Template("""# $package

$title as a controller of ros2_control, made by $mark. `src/$name.c` is the law, unchanged; its header says what it
takes and gives.

This package was written after the interfaces of ros2_control in Humble and Jazzy, and was compiled and run against
stubs of their headers alone: no ROS 2 was there where it was made. Build it with `colcon build`, and try it in
simulation before any machine is switched on.

| interface | signal |
| --- | --- |
$rows

$references
The controller must run once in $period s: it refuses to be activated at another rate, or where none is set:

```yaml
controller_manager:
  ros__parameters:
    update_rate: $rate
    $name:
      type: $package/Controller
$name:
  ros__parameters:
    update_rate: $rate
```

Where a number is not finite, and on deactivation, it commands $safe.
""")
