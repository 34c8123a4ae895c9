// PageEvents as they are kept for many viewers at once: a body without its sequence, encoded once
// and shared, and in front of it, made for each viewer, the field `sequence`. Two encodings of
// protobuf put together are the encoding of both. Pure. Not RT.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "hapticd/v1/gateway.pb.h"

namespace hapticd::web {

/// An encoded PageEvent without sequence; never changed, shared by the viewers that it waits for.
using SharedBody = std::shared_ptr<const std::string>;

/// `event` without its sequence.
[[nodiscard]] SharedBody body_of(v1::PageEvent event);
/// The body of a State, of an Item.
[[nodiscard]] SharedBody state_body(const v1::State& state);
[[nodiscard]] SharedBody item_body(const v1::Item& item);

/// The whole message: `sequence`, then `body`.
[[nodiscard]] std::string message_of(std::uint64_t sequence, const std::string& body);

}  // namespace hapticd::web
