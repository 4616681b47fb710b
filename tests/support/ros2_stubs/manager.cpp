// A manager of one controller. Arguments: update rate, number of references, periods before the first reference, and
// parameters as NAME=v,v,v. Rows of doubles come in, readings then references; commands go out, and in the end, after
// deactivation, the last ones.
#include <any>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "controller_interface/controller_interface.hpp"
#include "std_msgs/msg/float64_multi_array.hpp"

using controller_interface::CallbackReturn;
using std_msgs::msg::Float64MultiArray;
std::unique_ptr<controller_interface::ControllerInterface> new_plugin();

static void require(bool truth, const char * what, int code)
{
  if (!truth) {
    std::fprintf(stderr, "refused: %s\n", what);
    std::exit(code);
  }
}

int main(int count, char ** words)
{
  require(count >= 4, "arguments", 9);
  auto plugin = new_plugin();
  const std::size_t references = std::strtoul(words[2], nullptr, 10);
  const long silent = std::strtol(words[3], nullptr, 10);
  plugin->rate = static_cast<unsigned>(std::strtoul(words[1], nullptr, 10));
  for (int i = 4; i < count; ++i) {
    char * text = std::strchr(words[i], '=');
    std::vector<double> values;
    const std::string name(words[i], text);
    while (*text != 0) {
      values.push_back(std::strtod(text + 1, &text));
    }
    plugin->node->parameters[name] = values;
  }
  require(plugin->on_init() == CallbackReturn::SUCCESS, "on_init", 2);
  const auto readings = plugin->state_interface_configuration(), commands = plugin->command_interface_configuration();
  for (const auto & name : readings.names) {
    std::fprintf(stderr, "state %s\n", name.c_str());
  }
  for (const auto & name : commands.names) {
    std::fprintf(stderr, "command %s\n", name.c_str());
  }
  require(plugin->on_configure({}) == CallbackReturn::SUCCESS, "on_configure", 3);
  std::vector<double> y(readings.names.size()), u(commands.names.size(), 1e9), row(y.size() + references);
  for (auto & value : y) {
    plugin->state_interfaces_.emplace_back(&value);
  }
  for (auto & value : u) {
    plugin->command_interfaces_.emplace_back(&value);
  }
  require(plugin->on_activate({}) == CallbackReturn::SUCCESS, "on_activate", 4);
  const auto put = [&u]() { std::fwrite(u.data(), sizeof(double), u.size(), stdout); };
  for (long k = 0; std::fread(row.data(), sizeof(double), row.size(), stdin) == row.size(); ++k) {
    std::memcpy(y.data(), row.data(), y.size() * sizeof(double));
    if (references > 0 && k >= silent) {
      auto & held = plugin->node->subscriptions.at("~/references");
      const auto topic = std::any_cast<rclcpp::Subscription<Float64MultiArray>::SharedPtr>(held);
      auto message = std::make_shared<Float64MultiArray>();
      message->data.assign(row.begin() + static_cast<long>(y.size()), row.end());
      topic->heard(message);
      auto odd = std::make_shared<Float64MultiArray>();  // of another size: it must be left aside
      odd->data.assign(references + 1, 7.0);
      if (k == silent) {
        topic->heard(odd);
      }
    }
    require(plugin->update({}, {}) == controller_interface::return_type::OK, "update", 5);
    put();
  }
  require(plugin->on_deactivate({}) == CallbackReturn::SUCCESS, "on_deactivate", 6);
  put();
  return 0;
}
