// Who among the pages may do what. They share one session with the daemon, so that its lease is the
// session's: the desk gives it to one page at a time, and refuses in the daemon's words what the
// others ask. Pure. Not RT.
#pragma once

#include <cstdint>
#include <optional>

#include "hapticd/v1/stream.pb.h"

namespace hapticd::web {

/// Number of a viewer, from 1.
using ViewerId = std::uint64_t;

/// The answer to a page that asks for more than to look and may not.
[[nodiscard]] v1::Result only_looks();

/// Keeps the lease among the viewers.
class PageLease {
 public:
  /// Why `viewer` gets no further with `request`; nothing: the daemon decides. Without control
  /// nothing reaches the daemon, what only reads neither: a listing may cost more than its asking.
  [[nodiscard]] std::optional<v1::Result> refuse(ViewerId viewer, bool control,
                                                 const v1::Item& request) const;
  /// Why `viewer` may not choose what all pages see; nothing: it may.
  [[nodiscard]] std::optional<v1::Result> refuse_show(ViewerId viewer, bool control) const;
  /// `request` of `viewer` is on its way to the daemon.
  void asked(ViewerId viewer, const v1::Item& request);
  /// The daemon's answer to it, or null when the session ended.
  void answered(ViewerId viewer, const v1::Item& request, const v1::Result* result);
  /// What the daemon said about the lease, as `viewer` sees it.
  [[nodiscard]] v1::LeaseInfo seen_by(ViewerId viewer, const v1::LeaseInfo& told) const;
  /// The session does not have the lease any more.
  void lost() noexcept { holder_ = 0; }
  /// Whose page has it; 0 = none.
  [[nodiscard]] ViewerId holder() const noexcept { return holder_; }

 private:
  ViewerId holder_ = 0;
  ViewerId asking_ = 0;  ///< whose Acquire is on its way; 0 = none
};

}  // namespace hapticd::web
