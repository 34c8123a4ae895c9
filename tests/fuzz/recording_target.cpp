// See recording_target.h.
#include "tests/fuzz/recording_target.h"

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "proto/recording/mcap_reader.h"
#include "proto/recording/recorded_state.h"
#include "server/recorder/recorder.h"
#include "server/recorder/tick_record.h"

namespace hapticd::test {
namespace {

std::vector<std::string_view> read_all(McapReader& reader) {
  std::vector<std::string_view> found;
  const auto tick = std::make_unique<Tick>();
  McapMessage message;
  while (reader.next(message)) {
    found.push_back(message.data);
    if (message.channel != reader.channel_of(kTickTopic)) continue;
    v1::TickRecord record;
    if (record.ParseFromArray(message.data.data(), static_cast<int>(message.data.size()))) {
      (void)to_tick(record, *tick);
      (void)state_of(record);
    }
  }
  return found;
}

/// Writes 0, which says that there is none, over the CRC of every chunk that can be found.
std::string without_crcs(std::string_view bytes) {
  std::string copy(bytes);
  constexpr std::size_t kCrc = kMcapPrefix + 24;
  std::size_t place = kMcapMagic.size();
  while (place + kMcapPrefix <= copy.size()) {
    McapCursor cursor(std::string_view(copy).substr(place));
    const auto opcode = static_cast<McapOpcode>(cursor.number<std::uint8_t>());
    const auto length = cursor.number<std::uint64_t>();
    if (opcode == McapOpcode::kChunk && place + kCrc + 4 <= copy.size()) {
      copy.replace(place + kCrc, 4, 4, '\0');
    }
    if (length > copy.size() - place - kMcapPrefix) break;
    place += kMcapPrefix + length;
  }
  return copy;
}

bool check(std::string_view bytes) {
  McapReader reader(bytes);
  const std::vector<std::string_view> found = read_all(reader);
  if (reader.end() == McapEnd::kMore || reader.describe_end().empty()) {
    throw std::logic_error("a reading without an end");
  }
  return !found.empty();
}

}  // namespace

bool check_recording_bytes(std::span<const std::uint8_t> bytes) {
  const std::string copy(bytes.begin(), bytes.end());
  const bool as_it_is = check(copy);
  return check(without_crcs(copy)) || as_it_is;
}

}  // namespace hapticd::test
