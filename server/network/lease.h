// The lease: which session controls, under which fencing number, until when. PROTOCOL.md,
// section 9. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "server/network/server_host.h"
#include "server/network/sessions.h"

namespace hapticd {

class Lease {
 public:
  /// An answer to Acquire, whether others have to hear of it, and who has lost the lease by it.
  struct Granted {
    v1::Result result;
    bool changed = false;
    std::uint64_t lost_by = 0;  ///< serial number of the session; 0 = none
  };

  /// Both must outlive this.
  Lease(Sessions& sessions, const ServerHost& host) : sessions_(sessions), host_(host) {}

  [[nodiscard]] bool held_by(const Session& session) const noexcept {
    return session_ == session.serial;
  }
  /// Why the session may not make this request; nothing: it may.
  [[nodiscard]] std::optional<v1::Result> refusal(const Session& session,
                                                  const v1::Item& item) const;

  /// The answer to who would need the lease and has it no more, or not yet.
  [[nodiscard]] v1::Result not_owner(const Session& session) const;

  /// Gives the lease to `session`, unless another one holds it and no reason is given to take it
  /// over: then the host hears that the old lease is over. tell() after it was answered.
  [[nodiscard]] Granted acquire(const Session& session, const v1::Acquire& request);
  /// `session` lives: its lease goes on, if it has it.
  void renew(const Session& session) noexcept;
  /// Ends it if `session` holds it. The host hears of it.
  void give_up(const Session& session, LeaseEnd how);
  /// Ends it when its holder has been silent for 2 s, unless a Run of steps of the holder's is
  /// under way. The host hears of it.
  void expire();

  /// What everyone is told, but for whose it is.
  [[nodiscard]] v1::LeaseInfo info() const;
  /// What `session` is told.
  [[nodiscard]] v1::LeaseInfo info(const Session& session) const;
  /// Tells everyone.
  void tell();

  /// Name of the holder; empty when nobody holds it or gave no name.
  [[nodiscard]] const std::string& holder() const noexcept { return holder_; }
  /// Fencing number; 0 when nobody holds it.
  [[nodiscard]] std::uint64_t fence() const noexcept { return session_ == 0 ? 0 : fence_; }

 private:
  /// What is wrong with the texts of a request.
  [[nodiscard]] static std::optional<v1::Result> fault_of(const v1::Acquire& request);
  void end(LeaseEnd how);

  Sessions& sessions_;
  const ServerHost& host_;
  std::uint64_t session_ = 0;  ///< serial number of the holder; 0 = nobody
  std::uint64_t fence_ = 0;    ///< of the last grant
  std::string holder_;
  std::string key_name_;       ///< of the holder's session
  std::string taken_from_;     ///< holder before, where it was taken over
  std::string reason_;         ///< of the take-over
  std::uint64_t lost_by_ = 0;  ///< session that it was taken from; 0 = none
  std::int64_t renewed_ns_ = 0;
};

}  // namespace hapticd
