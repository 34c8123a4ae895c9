// See mcap_writer.h.
#include "proto/recording/mcap_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <new>
#include <system_error>

#include "proto/recording/mcap_bytes.h"

namespace hapticd {
namespace {

/// What a hand did is its owner's affair.
constexpr mode_t kOwnerOnly = 0600;

}  // namespace

McapWriter::~McapWriter() { close(); }

// What has failed is short enough to be kept without memory, as is want of it.
void McapWriter::fail(const char* what, int code) noexcept {
  if (!error_.empty()) return;
  try {
    error_ = path_ + ": " + what + ": " + std::generic_category().message(code);
  } catch (const std::bad_alloc&) {
    error_ = what;
  }
}

void McapWriter::fail_for_memory() noexcept {
  if (error_.empty()) error_ = "out of memory";
}

bool McapWriter::append(std::string_view bytes) {
  std::string_view rest = bytes;
  while (!rest.empty()) {
    const ssize_t written = ::write(file_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      fail("cannot write", written < 0 ? errno : EIO);
      // What was begun is taken back, so that the file ends with a whole record.
      if (::ftruncate(file_, static_cast<off_t>(length_)) != 0) fail("cannot cut", errno);
      return false;
    }
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  length_ += bytes.size();
  crc_ = mcap_crc(bytes, crc_);
  return true;
}

bool McapWriter::open(const std::string& path, std::string_view library) {
  path_ = path;
  file_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, kOwnerOnly);
  if (file_ < 0) {
    fail("cannot create", errno);
    return false;
  }
  std::string bytes(kMcapMagic);
  std::string header;
  put_text(header, "");  // profile: none
  put_text(header, library);
  put_record(bytes, McapOpcode::kHeader, header);
  return append(bytes);
}

std::uint16_t McapWriter::add_channel(std::string_view topic, std::string_view type_name,
                                      std::string_view file_descriptor_set) {
  const auto id = static_cast<std::uint16_t>(layout_.channels.size() + 1);
  layout_.schemas.push_back(
      {id, std::string(type_name), "protobuf", std::string(file_descriptor_set)});
  layout_.channels.push_back({id, id, std::string(topic), "protobuf"});
  sequence_.push_back(0);
  index_.emplace_back();
  if (is_open() && error_.empty()) {
    std::string bytes;
    put_record(bytes, McapOpcode::kSchema, schema_content(layout_.schemas.back()));
    put_record(bytes, McapOpcode::kChannel, channel_content(layout_.channels.back()));
    append(bytes);
  }
  return id;
}

bool McapWriter::write(std::uint16_t channel, std::uint64_t time_ns, std::string_view message) {
  if (!is_open() || !error_.empty()) {
    ++lost_;
    return false;
  }
  const std::size_t k = channel - 1U;
  const std::size_t size = chunk_.size();
  const std::size_t places = index_[k].size();
  try {
    put_message(k, time_ns, message);
  } catch (const std::bad_alloc&) {
    chunk_.resize(size);
    index_[k].resize(places);
    ++lost_;
    return false;
  }
  if (chunk_messages_++ == 0) start_time_ = end_time_ = time_ns;
  start_time_ = std::min(start_time_, time_ns);
  end_time_ = std::max(end_time_, time_ns);
  ++sequence_[k];
  if (chunk_.size() >= kChunkBytes) flush();
  return true;
}

void McapWriter::put_message(std::size_t k, std::uint64_t time_ns, std::string_view message) {
  index_[k].emplace_back(time_ns, chunk_.size());
  std::string head;
  put(head, static_cast<std::uint16_t>(k + 1));
  put(head, sequence_[k]);
  put(head, time_ns);
  put(head, time_ns);
  chunk_.push_back(static_cast<char>(McapOpcode::kMessage));
  put(chunk_, static_cast<std::uint64_t>(head.size() + message.size()));
  chunk_.append(head).append(message);
}

void McapWriter::flush() {
  if (chunk_messages_ == 0) return;
  try {
    write_chunk();
  } catch (const std::bad_alloc&) {
    if (chunk_.size() < kMaxChunkBytes) return;
    fail_for_memory();
    lost_ += chunk_messages_;
  }
  forget_chunk();
}

void McapWriter::forget_chunk() {
  for (auto& places : index_) places.clear();
  chunk_.clear();
  chunk_messages_ = 0;
}

std::string McapWriter::chunk_bytes(McapChunk& chunk) const {
  std::string content;
  put(content, start_time_);
  put(content, end_time_);
  put(content, static_cast<std::uint64_t>(chunk_.size()));
  put(content, mcap_crc(chunk_));
  put_text(content, "");  // not compressed
  put(content, static_cast<std::uint64_t>(chunk_.size()));
  content.append(chunk_);
  std::string bytes;
  bytes.reserve(content.size() + 32 * chunk_messages_);
  put_record(bytes, McapOpcode::kChunk, content);

  chunk = {start_time_, end_time_, length_, bytes.size(), {}, 0, chunk_.size()};
  for (std::size_t k = 0; k < index_.size(); ++k) {
    if (index_[k].empty()) continue;
    const auto channel = static_cast<std::uint16_t>(k + 1);
    chunk.index_offsets[channel] = length_ + bytes.size();
    std::string places;
    for (const auto& [time_ns, place] : index_[k]) {
      put(places, time_ns);
      put(places, place);
    }
    std::string index;
    put(index, channel);
    put_text(index, places);
    put_record(bytes, McapOpcode::kMessageIndex, index);
  }
  chunk.index_length = bytes.size() - chunk.length;
  return bytes;
}

// All that asks for memory comes before the file has the chunk.
void McapWriter::write_chunk() {
  McapChunk chunk{};
  const std::string bytes = chunk_bytes(chunk);
  auto counts = layout_.message_counts;
  for (std::size_t k = 0; k < index_.size(); ++k) {
    if (!index_[k].empty()) counts[static_cast<std::uint16_t>(k + 1)] += index_[k].size();
  }
  layout_.chunks.push_back(std::move(chunk));
  if (append(bytes)) {
    layout_.message_counts = std::move(counts);
  } else {
    layout_.chunks.pop_back();
    lost_ += chunk_messages_;
  }
}

bool McapWriter::close() {
  if (!is_open()) return false;
  if (error_.empty()) flush();
  try {
    if (error_.empty()) append(summary_bytes(layout_, length_, crc_));
  } catch (const std::bad_alloc&) {
    fail_for_memory();
  }
  if (chunk_messages_ != 0) fail_for_memory();
  if (::close(file_) != 0) fail("cannot close", errno);
  file_ = -1;
  return error_.empty();
}

}  // namespace hapticd
