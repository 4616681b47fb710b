#ifndef STUB_STATE_HPP_
#define STUB_STATE_HPP_
namespace rclcpp_lifecycle
{
struct State {};
}  // namespace rclcpp_lifecycle
#endif
