// See item_outbox.h.
#include "proto/wire/item_outbox.h"

#include <algorithm>
#include <utility>

namespace hapticd::wire {
namespace {

/// Tag of Packet.items: field 3, length-delimited.
constexpr char kItemsTag = 0x1a;

/// Bytes that tag, length and Item take in a Packet; an Item of at most kItemBytes.
std::size_t field_bytes(const std::string& item) {
  return item.size() + (item.size() < 128 ? 2 : 3);
}

std::string chunk_of(const std::string& blob, std::uint32_t number, std::size_t offset) {
  v1::Item item;
  v1::Chunk& chunk = *item.mutable_chunk();
  chunk.set_blob(number);
  chunk.set_kind(v1::CHUNK_KIND_ITEM);
  chunk.set_offset(static_cast<std::uint32_t>(offset));
  chunk.set_total(static_cast<std::uint32_t>(blob.size()));
  chunk.set_bytes(blob.substr(offset, kChunkBytes));
  return item.SerializeAsString();
}

}  // namespace

std::optional<std::uint64_t> ItemOutbox::add(const v1::Item& item) {
  std::string bytes = item.SerializeAsString();
  if (unacknowledged() >= kMaxUnacknowledged) return std::nullopt;
  if (bytes.size() > kItemBytes &&
      (bytes.size() > kBlobBytes || blob_bytes_held_ + bytes.size() > kMaxBlobBytesHeld)) {
    return std::nullopt;
  }
  return push(std::move(bytes));
}

std::uint64_t ItemOutbox::add_last(const v1::Item& item) { return push(item.SerializeAsString()); }

std::uint64_t ItemOutbox::push(std::string bytes) {
  Waiting waiting;
  if (bytes.size() > kItemBytes) {
    waiting.blob = ++blobs_;
    blob_bytes_held_ += bytes.size();
    next_id_ += (bytes.size() + kChunkBytes - 1) / kChunkBytes;
  } else {
    ++next_id_;
  }
  waiting.bytes = std::move(bytes);
  waiting_.push_back(std::move(waiting));
  refill();
  return next_id_ - 1;
}

void ItemOutbox::refill() {
  while (window_.size() < kMaxItems && !waiting_.empty()) {
    Waiting& next = waiting_.front();
    if (next.blob == 0) {
      window_.push_back(std::move(next.bytes));
      waiting_.pop_front();
      continue;
    }
    window_.push_back(chunk_of(next.bytes, next.blob, next.taken));
    next.taken += kChunkBytes;
    if (next.taken >= next.bytes.size()) {
      blob_bytes_held_ -= next.bytes.size();
      waiting_.pop_front();
    }
  }
}

bool ItemOutbox::acknowledge(std::uint64_t id) {
  if (id > highest_sent_) return false;
  while (acknowledged_ < id) {
    window_.pop_front();
    ++acknowledged_;
  }
  if (acknowledged_ == highest_sent_) repeat_due_ns_ = kNever_ns;
  refill();
  return true;
}

std::size_t ItemOutbox::fitting(std::size_t bytes) const noexcept {
  std::size_t count = 0;
  for (const std::string& item : window_) {
    const std::size_t size = field_bytes(item);
    if (size > bytes) break;
    bytes -= size;
    ++count;
  }
  return count;
}

void ItemOutbox::append(std::size_t count, std::string& packet) const {
  for (std::size_t i = 0; i < count; ++i) {
    const std::string& item = window_[i];
    packet += kItemsTag;
    if (item.size() < 128) {
      packet += static_cast<char>(item.size());
    } else {
      packet += static_cast<char>((item.size() & 0x7fU) | 0x80U);
      packet += static_cast<char>(item.size() >> 7U);
    }
    packet += item;
  }
}

void ItemOutbox::sent(std::size_t count, std::int64_t now_ns) noexcept {
  if (count == 0) return;
  const std::uint64_t last = acknowledged_ + count;
  if (last > highest_sent_) {
    highest_sent_ = last;
    newest_left_ns_ = now_ns;
    repeats_ = 0;
    repeat_due_ns_ = now_ns + kRepeats_ns[0];
    return;
  }
  // This Packet counts as the next of the schedule, and as those whose time has passed as well.
  ++repeats_;
  while (repeats_ < kRepeats_ns.size() && newest_left_ns_ + kRepeats_ns[repeats_] <= now_ns) {
    ++repeats_;
  }
  repeat_due_ns_ =
      repeats_ < kRepeats_ns.size() ? newest_left_ns_ + kRepeats_ns[repeats_] : now_ns + kRepeat_ns;
}

std::int64_t ItemOutbox::due_ns(std::size_t bytes) const noexcept {
  if (window_.empty()) return kNever_ns;
  if (acknowledged_ + fitting(bytes) > highest_sent_) return 0;
  return repeat_due_ns_;
}

}  // namespace hapticd::wire
