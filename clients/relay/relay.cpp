// See relay.h.
#include "clients/relay/relay.h"

namespace hapticd::relay {
namespace {

/// Topic of a kind of Item, and whether the broker keeps it; null: it is not relayed.
std::pair<const char*, bool> topic_of(const v1::Item& item) {
  switch (item.body_case()) {
    case v1::Item::kTone:
      return {"/tone", false};
    case v1::Item::kContact:
      return {"/contact", false};
    case v1::Item::kStringRadius:
      return {"/string", false};
    case v1::Item::kStringSounding:
      return {"/sounding", false};
    case v1::Item::kFault:
      return {"/fault", true};
    case v1::Item::kSceneInfo:
      return {"/scene", true};
    case v1::Item::kLeaseInfo:
      return {"/lease", true};
    case v1::Item::kRecordInfo:
      return {"/record", true};
    default:
      return {nullptr, false};
  }
}

}  // namespace

std::optional<Publication> publication_of(const std::string& prefix, const v1::Item& item) {
  const auto [topic, retained] = topic_of(item);
  if (topic == nullptr) return std::nullopt;
  return Publication{prefix + topic, item.SerializeAsString(), retained, 1};
}

Publication publication_of(const std::string& prefix, const v1::State& state) {
  return {prefix + "/state", state.SerializeAsString(), false, 0};
}

Publication link_publication(const std::string& prefix, bool live) {
  return {prefix + "/link", live ? "live" : "gone", true, 1};
}

void Relay::item(const v1::Item& item) {
  if (const auto publication = publication_of(prefix_, item)) publish(*publication);
}

void Relay::state(const v1::State& state) { publish(publication_of(prefix_, state)); }

void Relay::link(bool live) { publish(link_publication(prefix_, live)); }

void Relay::connected() {
  for (const auto& [topic, publication] : kept_) {
    if (publish_(publication)) ++counters_.published;
  }
}

void Relay::publish(const Publication& publication) {
  if (publication.retained) kept_[publication.topic] = publication;
  if (publish_(publication)) {
    ++counters_.published;
  } else {
    ++counters_.lost;
  }
}

}  // namespace hapticd::relay
