// See viewer_queue.h.
#include "clients/web/gateway/viewer_queue.h"

#include <algorithm>
#include <utility>

namespace hapticd::web {

void ViewerQueue::add_state(SharedBody body) {
  if (states_ > 0 && states_ >= limits_.states) {
    waiting_.erase(std::find_if(waiting_.begin(), waiting_.end(),
                                [](const Waiting& each) { return each.is_state; }));
    --states_;
    ++dropped_;
  }
  waiting_.push_back({++sequence_, true, std::move(body)});
  ++states_;
}

bool ViewerQueue::add(SharedBody body) {
  const std::size_t kept = waiting_.size() - states_;
  const std::size_t bytes = kept_bytes_ + body->size();
  if (kept >= limits_.kept || (kept > 0 && bytes > limits_.kept_bytes)) return false;
  kept_bytes_ = bytes;
  waiting_.push_back({++sequence_, false, std::move(body)});
  return true;
}

std::optional<std::string> ViewerQueue::take() {
  if (waiting_.empty()) return std::nullopt;
  const Waiting next = std::move(waiting_.front());
  waiting_.pop_front();
  if (next.is_state) {
    --states_;
  } else {
    kept_bytes_ -= next.body->size();
  }
  return message_of(next.sequence, *next.body);
}

}  // namespace hapticd::web
