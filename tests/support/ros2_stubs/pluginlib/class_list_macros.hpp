#ifndef STUB_CLASS_LIST_MACROS_HPP_
#define STUB_CLASS_LIST_MACROS_HPP_
#include <memory>
#define PLUGINLIB_EXPORT_CLASS(kind, base) \
  std::unique_ptr<base> new_plugin() { return std::make_unique<kind>(); }
#endif
