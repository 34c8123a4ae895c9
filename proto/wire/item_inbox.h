// The receiving half of "exactly once, in order": PROTOCOL.md, sections 4 and 5. Applies only the
// next id, puts Chunks together, and says when the peer has broken the rules. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hapticd/v1/stream.pb.h"

namespace hapticd::wire {

/// An Item that has arrived, to be applied now.
struct ReceivedItem {
  std::uint64_t id = 0;  ///< its own, or that of the last Chunk it came in
  v1::Item item;
  std::size_t bytes = 0;     ///< of its encoding
  bool undecodable = false;  ///< a blob that is not an Item: to be answered INVALID
};

struct ReceivedItems {
  std::vector<ReceivedItem> items;  ///< in order; those before a broken one too
  bool any_listed = false;          ///< the Packet had Items, new or not: acknowledge soon
  bool any_new = false;             ///< some id was applied, even if only a piece
  const char* broken = nullptr;     ///< the rule the peer broke: the session has to end; else null
};

/// What has arrived in one direction of a session.
class ItemInbox {
 public:
  /// Packet.ack: the highest id applied.
  [[nodiscard]] std::uint64_t applied() const noexcept { return applied_; }

  /// From now on a Packet whose Items come early is skipped; before, it breaks the session.
  void skip_early() noexcept { skips_early_ = true; }

  /// The Items of `packet` that come next. Moves them out of it.
  ReceivedItems take(v1::Packet& packet);

 private:
  /// Takes one Chunk; the rule it breaks, or null. Appends to `out` when it was the last of a blob.
  const char* take_chunk(const v1::Chunk& chunk, std::vector<ReceivedItem>& out);

  bool skips_early_ = false;
  std::uint64_t applied_ = 0;
  std::string blob_;               ///< pieces so far
  std::uint32_t blob_number_ = 0;  ///< of the blob under way or finished last
  std::uint32_t blob_total_ = 0;   ///< 0: none under way
  int blob_kind_ = 0;
};

}  // namespace hapticd::wire
