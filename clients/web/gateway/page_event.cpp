// See page_event.h.
#include "clients/web/gateway/page_event.h"

#include <utility>

namespace hapticd::web {

SharedBody body_of(v1::PageEvent event) {
  event.clear_sequence();
  return std::make_shared<const std::string>(event.SerializeAsString());
}

SharedBody state_body(const v1::State& state) {
  v1::PageEvent event;
  *event.mutable_state() = state;
  return body_of(std::move(event));
}

SharedBody item_body(const v1::Item& item) {
  v1::PageEvent event;
  *event.mutable_item() = item;
  return body_of(std::move(event));
}

std::string message_of(std::uint64_t sequence, const std::string& body) {
  v1::PageEvent head;
  head.set_sequence(sequence);
  return head.SerializeAsString() + body;
}

}  // namespace hapticd::web
