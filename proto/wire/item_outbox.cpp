// See item_outbox.h.
#include "proto/wire/item_outbox.h"

#include <iterator>
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
  const bool blob = bytes.size() > kItemBytes;
  if (blob && (bytes.size() > kBlobBytes || blob_bytes_held_ + bytes.size() > kMaxBlobBytesHeld)) {
    return std::nullopt;
  }
  Place place = Place::kKeeps;
  if (blob && item.has_result()) place = Place::kIsOvertaken;
  if (!blob && !item.has_scene_info()) place = Place::kOvertakes;
  return push(std::move(bytes), place);
}

std::uint64_t ItemOutbox::add_last(const v1::Item& item) {
  return push(item.SerializeAsString(), Place::kKeeps);
}

std::uint64_t ItemOutbox::push(std::string bytes, Place place) {
  Waiting waiting;
  waiting.place = place;
  if (bytes.size() > kItemBytes) {
    waiting.blob = ++blobs_;
    blob_bytes_held_ += bytes.size();
    next_id_ += (bytes.size() + kChunkBytes - 1) / kChunkBytes;
  } else {
    ++next_id_;
  }
  waiting.bytes = std::move(bytes);
  auto before = waiting_.end();
  if (place == Place::kOvertakes && overtaking_ == Overtaking::kResults && ahead_.allowed()) {
    while (before != waiting_.begin() && std::prev(before)->place == Place::kIsOvertaken) --before;
  }
  waiting_.insert(before, std::move(waiting));
  refill();
  return next_id_ - 1;
}

bool ItemOutbox::fits_one_packet() const noexcept {
  return !ahead_.allowed() ||
         (waiting_.empty() && window_.size() <= kMaxItems && window_bytes_ <= kItemsBytes);
}

bool ItemOutbox::wants_more() const noexcept {
  if (!ahead_.allowed()) return window_.size() < kMaxItems;
  std::size_t bytes = 0;
  const auto left = static_cast<std::size_t>(highest_sent_ - acknowledged_);
  for (std::size_t i = left; i < window_.size(); ++i) bytes += field_bytes(window_[i]);
  return window_.size() < left + kMaxItems && bytes < kItemsBytes;
}

void ItemOutbox::refill() {
  while (!waiting_.empty() && wants_more()) {
    Waiting& next = waiting_.front();
    if (next.blob == 0) {
      window_.push_back(std::move(next.bytes));
      waiting_.pop_front();
    } else {
      window_.push_back(chunk_of(next.bytes, next.blob, next.taken));
      next.taken += kChunkBytes;
      if (next.taken >= next.bytes.size()) {
        blob_bytes_held_ -= next.bytes.size();
        waiting_.pop_front();
      }
    }
    window_bytes_ += field_bytes(window_.back());
  }
}

bool ItemOutbox::acknowledge(std::uint64_t id, std::int64_t now_ns) {
  if (id > highest_sent_) return false;
  if (id > acknowledged_) {
    ahead_.acknowledged(id, now_ns);
    if (ahead_.allowed()) begin_schedule(now_ns);
  }
  while (acknowledged_ < id) {
    window_bytes_ -= field_bytes(window_.front());
    window_.pop_front();
    ++acknowledged_;
  }
  if (acknowledged_ == highest_sent_) repeat_due_ns_ = kNever_ns;
  refill();
  return true;
}

void ItemOutbox::prepare(std::int64_t now_ns) {
  if (!ahead_.allowed()) return;
  refill();
  if (!fits_one_packet() && ahead_.due_ns() <= now_ns) ahead_.turn_back(now_ns);
}

std::size_t ItemOutbox::fitting(std::size_t bytes) const noexcept {
  if (!fits_one_packet() && !ahead_.room()) return 0;
  std::size_t count = 0;
  for (std::size_t i = leaving(); i < window_.size() && count < kMaxItems; ++i) {
    const std::size_t size = field_bytes(window_[i]);
    if (size > bytes) break;
    bytes -= size;
    ++count;
  }
  return count;
}

void ItemOutbox::append(std::size_t count, std::string& packet) const {
  const std::size_t begin = leaving();
  for (std::size_t i = begin; i < begin + count; ++i) {
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

void ItemOutbox::begin_schedule(std::int64_t now_ns) noexcept {
  newest_left_ns_ = now_ns;
  repeats_ = 0;
  repeat_due_ns_ = now_ns + kRepeats_ns[0];
}

void ItemOutbox::sent(std::size_t count, std::int64_t now_ns) noexcept {
  if (count == 0) return;
  const std::uint64_t first = leaving_id();
  const std::uint64_t last = first + count - 1;
  const bool further = !fits_one_packet();
  ahead_.left(first, last, now_ns);
  if (last > highest_sent_) {
    highest_sent_ = last;
    begin_schedule(now_ns);
    return;
  }
  if (further) return;
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
  if (!fits_one_packet()) {
    const bool any = leaving() < window_.size() || !waiting_.empty();
    return any && ahead_.room() ? 0 : ahead_.due_ns();
  }
  if (acknowledged_ + fitting(bytes) > highest_sent_) return 0;
  return repeat_due_ns_;
}

}  // namespace hapticd::wire
