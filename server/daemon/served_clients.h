// The clients as the daemon's desks see them: what is answered later than it was asked for, and
// what everyone is told. Desks are made before anybody is served. Not RT.
#pragma once

#include <optional>
#include <utility>

#include "core/rt/memory_boundary.h"
#include "server/network/protocol_server.h"

namespace hapticd {

/// A request's result; nothing: it is answered later, once, by ServedClients::answer().
using Answer = std::optional<v1::Result>;

class ServedClients {
 public:
  /// `server` serves from here on, and outlives this.
  void serve_by(ProtocolServer& server) noexcept { server_ = &server; }

  /// The result of a request that was to be answered later.
  void answer(const RequestId& id, v1::Result result) {
    if (server_ != nullptr) server_->answer(id, std::move(result));
  }
  /// The same where the result itself is made here: without memory for it the session ends.
  template <typename MakeResult>
  void answer_with(const RequestId& id, MakeResult&& make_result) {
    if (!within_memory([&] { answer(id, make_result()); }) && server_ != nullptr) server_->fall(id);
  }
  /// An Item for everyone.
  void tell(const v1::Item& item) {
    if (server_ != nullptr) server_->broadcast(item);
  }
  /// Whether virtual time may take its next tick as far as clients are concerned.
  [[nodiscard]] bool may_step(std::int64_t now_ns) {
    return server_ == nullptr || server_->may_step(now_ns);
  }

 private:
  ProtocolServer* server_ = nullptr;
};

}  // namespace hapticd
