#ifndef STUB_REALTIME_BUFFER_HPP_
#define STUB_REALTIME_BUFFER_HPP_
namespace realtime_tools
{
template <class T>
class RealtimeBuffer
{
public:
  T * readFromRT() { return &value_; }
  void writeFromNonRT(const T & value) { value_ = value; }

private:
  T value_ = T();
};
}  // namespace realtime_tools
#endif
