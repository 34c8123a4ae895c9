// See controller.h.
#include "clients/library/controller.h"

#include <utility>

namespace hapticd::client {

v1::Result Controller::acquire(const std::string& holder, std::chrono::nanoseconds timeout) {
  v1::Item item;
  item.mutable_acquire()->set_holder(holder);
  return acquire(item, timeout);
}

v1::Result Controller::take_over(const std::string& holder, const std::string& reason,
                                 std::chrono::nanoseconds timeout) {
  v1::Item item;
  item.mutable_acquire()->set_holder(holder);
  item.mutable_acquire()->set_take_over(reason);
  return acquire(item, timeout);
}

v1::Result Controller::acquire(const v1::Item& item, std::chrono::nanoseconds timeout) {
  v1::Result result = client_.call(item, timeout);
  if (result.code() != v1::RESULT_CODE_OK) return result;
  fence_ = result.lease().fence();
  // LeaseInfo follows the Result.
  client_.poll_until([this] { return client_.lease().fence() >= fence_; }, timeout);
  return result;
}

bool Controller::holds() const {
  return fence_ != 0 && client_.lease().yours() && client_.lease().fence() == fence_;
}

v1::Result Controller::release() {
  v1::Item item;
  item.mutable_release();
  v1::Result result = call(std::move(item));
  fence_ = 0;
  return result;
}

v1::Result Controller::load_scene(const std::string& name, std::chrono::nanoseconds timeout) {
  v1::Item item;
  item.mutable_load_scene()->set_name(name);
  return call(std::move(item), timeout);
}

void Controller::pose(std::uint32_t tool_id, const v1::Pose& pose_dh,
                      const std::optional<v1::Twist>& twist_dh_d) {
  v1::PoseSample& sample = *batch_.mutable_pose_batch()->add_poses();
  sample.set_tool_id(tool_id);
  *sample.mutable_pose_dh() = pose_dh;
  if (twist_dh_d.has_value()) *sample.mutable_twist_dh_d() = *twist_dh_d;
  batch_moves_ = batch_moves_ || twist_dh_d.has_value();
  const int most = batch_moves_ ? kMovingPosesPerBatch : kPosesPerBatch;
  if (batch_.pose_batch().poses_size() >= most) flush();
}

v1::Result Controller::run(std::uint64_t steps, std::chrono::nanoseconds timeout) {
  v1::Item item;
  item.mutable_run()->set_mode(v1::RUN_MODE_STEP);
  item.mutable_run()->set_steps(steps);
  return call(std::move(item), timeout);
}

v1::Result Controller::call(v1::Item request, std::chrono::nanoseconds timeout) {
  flush();
  if (request.has_acquire()) return acquire(request, timeout);
  request.set_fence(fence_);
  return client_.call(request, timeout);
}

v1::Result Controller::stop() {
  v1::Item item;
  item.mutable_stop();
  return client_.call(item);
}

void Controller::flush() {
  if (batch_.pose_batch().poses_size() == 0) return;
  batch_.set_fence(fence_);
  client_.request(batch_);
  batch_.Clear();
  batch_moves_ = false;
}

}  // namespace hapticd::client
