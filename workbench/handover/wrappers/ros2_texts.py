"""The texts of a controller of ros2_control around the C of a law."""

from string import Template

HEADER = Template("""// $title: a controller of ros2_control around src/$name.c. Made by $mark.
#ifndef ${upper}_CONTROLLER_HPP_
#define ${upper}_CONTROLLER_HPP_

#include <memory>
#include <string>
#include <vector>

#include "controller_interface/controller_interface.hpp"
#include "rclcpp/rclcpp.hpp"
#include "rclcpp_lifecycle/state.hpp"
$reference_includes#include "$name.h"

namespace $package
{

class Controller : public controller_interface::ControllerInterface
{
public:
  controller_interface::CallbackReturn on_init() override;
  controller_interface::InterfaceConfiguration command_interface_configuration() const override;
  controller_interface::InterfaceConfiguration state_interface_configuration() const override;
  controller_interface::CallbackReturn on_configure(const rclcpp_lifecycle::State & previous) override;
  controller_interface::CallbackReturn on_activate(const rclcpp_lifecycle::State & previous) override;
  controller_interface::CallbackReturn on_deactivate(const rclcpp_lifecycle::State & previous) override;
  controller_interface::return_type update(const rclcpp::Time & time, const rclcpp::Duration & period) override;

private:
  void command(const $real * values);

  ${name}_state state_;
$reference_members};

}  // namespace $package

#endif  // ${upper}_CONTROLLER_HPP_
""")

REFERENCE_INCLUDES = """#if __has_include("realtime_tools/realtime_buffer.hpp")
#include "realtime_tools/realtime_buffer.hpp"
#else
#include "realtime_tools/realtime_buffer.h"  // Humble
#endif
#include "std_msgs/msg/float64_multi_array.hpp"

"""

REFERENCE_MEMBERS = Template("""
  struct Wanted  // what the last message asked for, if there was one
  {
    bool there = false;
    ${name}_references values = {};
  };
  realtime_tools::RealtimeBuffer<Wanted> wanted_;
  rclcpp::Subscription<std_msgs::msg::Float64MultiArray>::SharedPtr subscription_;
""")

SOURCE = Template("""// $title: a controller of ros2_control around $name.c. Made by $mark.
#include "$package/${name}_controller.hpp"

#include <cmath>
#include <cstddef>
#include <cstring>

#include "pluginlib/class_list_macros.hpp"

namespace $package
{

namespace
{
constexpr std::size_t READINGS = $readings, COMMANDS = $commands;
const char * const STATE_INTERFACES[READINGS] = {
$state_names
};
const char * const COMMAND_INTERFACES[COMMANDS] = {
$command_names
};
const $real SAFE[COMMANDS] = {$safe};

// All members of a struct are of one type, so that it is so many numbers in a row.
static_assert(sizeof(${name}_readings) == READINGS * sizeof($real), "$name.h is of another law");
static_assert(sizeof(${name}_commands) == COMMANDS * sizeof($real), "$name.h is of another law");
$reference_assertion}  // namespace

controller_interface::CallbackReturn Controller::on_init()
{
  ${name}_init(&state_);
$declarations  return controller_interface::CallbackReturn::SUCCESS;
}

controller_interface::InterfaceConfiguration Controller::command_interface_configuration() const
{
  return {
    controller_interface::interface_configuration_type::INDIVIDUAL,
    {COMMAND_INTERFACES, COMMAND_INTERFACES + COMMANDS}};
}

controller_interface::InterfaceConfiguration Controller::state_interface_configuration() const
{
  return {
    controller_interface::interface_configuration_type::INDIVIDUAL,
    {STATE_INTERFACES, STATE_INTERFACES + READINGS}};
}

controller_interface::CallbackReturn Controller::on_configure(const rclcpp_lifecycle::State &)
{
$settings$subscription  return controller_interface::CallbackReturn::SUCCESS;
}

controller_interface::CallbackReturn Controller::on_activate(const rclcpp_lifecycle::State &)
{
  const double periods = get_update_rate() * ${upper}_PERIOD;  // of the law, in a second
  if (!(std::fabs(periods - 1.0) < 1e-6)) {
    RCLCPP_ERROR(
      get_node()->get_logger(),
      "The law was made for %.9g s a period, an update rate of %.9g Hz; this controller has %u.", ${upper}_PERIOD,
      1.0 / ${upper}_PERIOD, static_cast<unsigned>(get_update_rate()));
    return controller_interface::CallbackReturn::FAILURE;
  }
  if (state_interfaces_.size() != READINGS || command_interfaces_.size() != COMMANDS) {
    RCLCPP_ERROR(get_node()->get_logger(), "The hardware lacks interfaces that this controller asks for.");
    return controller_interface::CallbackReturn::FAILURE;
  }
  ${name}_reset(&state_);
$forget  return controller_interface::CallbackReturn::SUCCESS;
}

controller_interface::CallbackReturn Controller::on_deactivate(const rclcpp_lifecycle::State &)
{
  command(SAFE);
  return controller_interface::CallbackReturn::SUCCESS;
}

controller_interface::return_type Controller::update(const rclcpp::Time &, const rclcpp::Duration &)
{
$unheard  $real numbers[READINGS];
  for (std::size_t i = 0; i < READINGS; ++i) {
    numbers[i] = static_cast<$real>(state_interfaces_[i].get_value());
  }
  ${name}_readings readings;
  ${name}_commands commands;
  std::memcpy(&readings, numbers, sizeof(readings));
  const unsigned before = state_.flags;
  const unsigned flags = ${name}_step(&state_, &readings, $reference&commands);
  if (flags != before) {
    RCLCPP_WARN(get_node()->get_logger(), "flags %u: %s", flags, flags ? "the safe command" : "all is well again");
  }
  $real values[COMMANDS];
  std::memcpy(values, &commands, sizeof(values));
  command(values);
  return controller_interface::return_type::OK;
}

void Controller::command(const $real * values)
{
  for (std::size_t i = 0; i < command_interfaces_.size() && i < COMMANDS; ++i) {
    static_cast<void>(command_interfaces_[i].set_value(static_cast<double>(values[i])));
  }
}

}  // namespace $package

PLUGINLIB_EXPORT_CLASS($package::Controller, controller_interface::ControllerInterface)
""")

REFERENCE_ASSERTION = Template("""constexpr std::size_t REFERENCES = $references;
static_assert(sizeof(${name}_references) == REFERENCES * sizeof($real), "$name.h is of another law");
""")

SUBSCRIPTION = Template("""  subscription_ = get_node()->create_subscription<std_msgs::msg::Float64MultiArray>(
    "~/references", rclcpp::SystemDefaultsQoS(), [this](const std_msgs::msg::Float64MultiArray::SharedPtr message) {
      if (message->data.size() != REFERENCES) {
        RCLCPP_WARN(
          get_node()->get_logger(), "~/references takes %zu numbers, and got %zu.", REFERENCES, message->data.size());
        return;
      }
      $real numbers[REFERENCES];
      for (std::size_t i = 0; i < REFERENCES; ++i) {
        numbers[i] = static_cast<$real>(message->data[i]);
      }
      Wanted wanted;
      wanted.there = true;
      std::memcpy(&wanted.values, numbers, sizeof(wanted.values));
      wanted_.writeFromNonRT(wanted);
    });
""")

UNHEARD = """  const Wanted * const wanted = wanted_.readFromRT();
  if (!wanted->there) {  // nothing is asked for yet
    command(SAFE);
    return controller_interface::return_type::OK;
  }
"""

SETTINGS = Template("""  for (const auto & parameter : PARAMETERS) {
    const auto values = get_node()->get_parameter(parameter.name).as_double_array();
    if (values.size() != parameter.size) {
      RCLCPP_ERROR(
        get_node()->get_logger(), "The parameter %s has %zu numbers; got %zu.", parameter.name, parameter.size,
        values.size());
      return controller_interface::CallbackReturn::FAILURE;
    }
    std::memcpy(
      reinterpret_cast<char *>(&state_.parameters) + parameter.offset, values.data(), parameter.size * sizeof(double));
  }
""")

DECLARATIONS = """  for (const auto & parameter : PARAMETERS) {
    std::vector<double> values(parameter.size);
    std::memcpy(
      values.data(), reinterpret_cast<const char *>(&state_.parameters) + parameter.offset,
      parameter.size * sizeof(double));
    auto_declare<std::vector<double>>(parameter.name, values);
  }
"""

PARAMETERS = Template("""struct Parameter
{
  const char * name;
  std::size_t size, offset;  // in numbers, and in bytes
};
const Parameter PARAMETERS[] = {
$rows
};
""")
