// The part of rclcpp that a generated controller uses, written for tests from its documentation (Humble, Jazzy).
#ifndef STUB_RCLCPP_HPP_
#define STUB_RCLCPP_HPP_

#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace rclcpp
{
struct Time {};
struct Duration {};
struct Logger {};
struct SystemDefaultsQoS {};

template <typename Message>
struct Subscription
{
  using SharedPtr = std::shared_ptr<Subscription>;
  std::string topic;
  std::function<void(typename Message::SharedPtr)> heard;
};

struct Parameter
{
  std::vector<double> values;
  std::vector<double> as_double_array() const { return values; }
};
}  // namespace rclcpp

#define RCLCPP_LOG(logger, ...) \
  do { \
    static_cast<void>(logger); \
    std::fprintf(stderr, __VA_ARGS__); \
    std::fputc('\n', stderr); \
  } while (0)
#define RCLCPP_WARN(logger, ...) RCLCPP_LOG(logger, __VA_ARGS__)
#define RCLCPP_ERROR(logger, ...) RCLCPP_LOG(logger, __VA_ARGS__)

#endif
