// What has arrived and is not read yet, where much of it comes at once. Pure. Not RT.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <iterator>
#include <vector>

namespace hapticd::client {

/// Appends all of `come`, however many. What was there before makes room, oldest first, until no
/// more than `keep` are left in all, or none of it. Returns how many went.
template <typename Message>
std::uint64_t append_unread(std::vector<Message>&& come, std::size_t keep,
                            std::deque<Message>& unread) {
  if (come.empty()) return 0;
  const std::size_t room = keep - std::min(keep, come.size());
  const std::size_t dropped = unread.size() - std::min(unread.size(), room);
  unread.erase(unread.begin(), unread.begin() + static_cast<std::ptrdiff_t>(dropped));
  unread.insert(unread.end(), std::make_move_iterator(come.begin()),
                std::make_move_iterator(come.end()));
  return dropped;
}

}  // namespace hapticd::client
