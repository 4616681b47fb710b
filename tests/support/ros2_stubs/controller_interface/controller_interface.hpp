// The part of controller_interface that a generated controller uses, written for tests from its documentation.
#ifndef STUB_CONTROLLER_INTERFACE_HPP_
#define STUB_CONTROLLER_INTERFACE_HPP_

#include <any>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "rclcpp/rclcpp.hpp"
#include "rclcpp_lifecycle/state.hpp"

namespace hardware_interface
{
class LoanedStateInterface
{
public:
  explicit LoanedStateInterface(double * value) : value_(value) {}
  double get_value() const { return *value_; }

private:
  double * value_;
};

class LoanedCommandInterface
{
public:
  explicit LoanedCommandInterface(double * value) : value_(value) {}
  [[nodiscard]] bool set_value(double value)
  {
    *value_ = value;
    return true;
  }

private:
  double * value_;
};
}  // namespace hardware_interface

namespace controller_interface
{
enum class CallbackReturn { SUCCESS, FAILURE, ERROR };
enum class return_type { OK, ERROR };
enum class interface_configuration_type { ALL, INDIVIDUAL, NONE };
struct InterfaceConfiguration
{
  interface_configuration_type type;
  std::vector<std::string> names = {};
};

class Node
{
public:
  rclcpp::Logger get_logger() const { return {}; }
  rclcpp::Parameter get_parameter(const std::string & name) const { return {parameters.at(name)}; }

  template <typename Message, typename Heard>
  typename rclcpp::Subscription<Message>::SharedPtr create_subscription(
    const std::string & topic, const rclcpp::SystemDefaultsQoS &, Heard heard)
  {
    auto subscription = std::make_shared<rclcpp::Subscription<Message>>();
    subscription->topic = topic;
    subscription->heard = heard;
    subscriptions[topic] = subscription;
    return subscription;
  }

  std::map<std::string, std::vector<double>> parameters;
  std::map<std::string, std::any> subscriptions;
};

class ControllerInterface
{
public:
  virtual ~ControllerInterface() = default;
  virtual CallbackReturn on_init() = 0;
  virtual InterfaceConfiguration command_interface_configuration() const = 0;
  virtual InterfaceConfiguration state_interface_configuration() const = 0;
  virtual CallbackReturn on_configure(const rclcpp_lifecycle::State &) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_activate(const rclcpp_lifecycle::State &) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_deactivate(const rclcpp_lifecycle::State &) { return CallbackReturn::SUCCESS; }
  virtual return_type update(const rclcpp::Time &, const rclcpp::Duration &) = 0;
  unsigned int get_update_rate() const { return rate; }
  std::shared_ptr<Node> get_node() const { return node; }

  template <typename Value>
  Value auto_declare(const std::string & name, const Value & value)
  {
    return node->parameters.try_emplace(name, value).first->second;
  }

  unsigned int rate = 0;
  std::shared_ptr<Node> node = std::make_shared<Node>();
  std::vector<hardware_interface::LoanedCommandInterface> command_interfaces_;
  std::vector<hardware_interface::LoanedStateInterface> state_interfaces_;
};
}  // namespace controller_interface

#endif
