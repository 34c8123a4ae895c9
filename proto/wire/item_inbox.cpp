// See item_inbox.h.
#include "proto/wire/item_inbox.h"

#include <google/protobuf/stubs/logging.h>

#include <utility>

#include "proto/wire/item_outbox.h"

namespace hapticd::wire {

ReceivedItems ItemInbox::take(v1::Packet& packet) {
  ReceivedItems result;
  result.any_listed = packet.items_size() > 0;
  if (result.any_listed && packet.first() > applied_ + 1) {
    if (!skips_early_) result.broken = "Items were dropped that had not been acknowledged";
    return result;
  }
  // Here first + i cannot overflow before it reaches the next id.
  for (int i = 0; i < packet.items_size(); ++i) {
    if (packet.first() + static_cast<std::uint64_t>(i) != applied_ + 1) continue;
    ++applied_;
    result.any_new = true;
    v1::Item& item = *packet.mutable_items(i);
    if (item.has_chunk()) {
      result.broken = take_chunk(item.chunk(), result.items);
      if (result.broken != nullptr) return result;
    } else {
      const std::size_t bytes = item.ByteSizeLong();
      result.items.push_back({applied_, std::move(item), bytes, false});
    }
  }
  return result;
}

const char* ItemInbox::take_chunk(const v1::Chunk& chunk, std::vector<ReceivedItem>& out) {
  const std::size_t size = chunk.bytes().size();
  if (size == 0 || size > kChunkBytes) return "a Chunk has 1 to 900 bytes";
  if (blob_total_ == 0) {
    if (chunk.total() == 0 || chunk.total() > kBlobBytes) return "a blob has 1 byte to 4 MiB";
    if (chunk.blob() != blob_number_ + 1) return "blobs are counted from 1";
    blob_number_ = chunk.blob();
    blob_total_ = chunk.total();
    blob_kind_ = chunk.kind();
    blob_.clear();
  }
  if (chunk.blob() != blob_number_ || chunk.total() != blob_total_ || chunk.kind() != blob_kind_) {
    return "all Chunks of a blob have its number, kind and total";
  }
  if (chunk.offset() != blob_.size() || size > blob_total_ - blob_.size()) {
    return "Chunks come in order and end with their blob";
  }
  blob_ += chunk.bytes();
  if (blob_.size() < blob_total_) return nullptr;

  ReceivedItem received{applied_, {}, blob_.size(), false};
  const google::protobuf::LogSilencer silence;  // As in parse_packet().
  // A kind of a later version is an Item without a body: acknowledged and skipped.
  if (blob_kind_ == v1::CHUNK_KIND_ITEM)
    received.undecodable = !received.item.ParseFromString(blob_);
  if (received.undecodable) received.item.Clear();
  blob_total_ = 0;
  blob_ = {};
  if (received.item.has_chunk()) return "a Chunk does not contain a Chunk";
  out.push_back(std::move(received));
  return nullptr;
}

}  // namespace hapticd::wire
