// See recording_reader.h.
#include "proto/recording/recording_reader.h"

#include "proto/recording/default_recordings.h"

namespace hapticd {

RecordingReader::RecordingReader(const std::string& path) : path_(find_recording(path)) {
  std::string error;
  if (!file_.open(path_, error)) {
    const bool looked_for = path.find('/') == std::string::npos;
    const std::string also = ". It is neither here nor in " + default_recordings().string() +
                             " or " + service_recordings().string() +
                             ". A hapticd that keeps its recordings elsewhere names the file when "
                             "it is asked to record: give its path.";
    throw RecordingError(error + (looked_for ? also : ". Name a file that hapticd recorded."));
  }
  rewind();
}

void RecordingReader::rewind() {
  reader_.emplace(file_.bytes());
  RecordedMessage message;
  if (!next(message) || message.kind != RecordKind::kHeader ||
      !header_.ParseFromArray(message.data.data(), static_cast<int>(message.data.size()))) {
    throw RecordingError(path_ + ": not a recording of hapticd (" + reader_->describe_end() +
                         "). Name a file that hapticd recorded.");
  }
  if (header_.format_version() < kOldestRecordFormat || header_.format_version() > kRecordFormat) {
    throw RecordingError(path_ + ": recorded in format " +
                         std::to_string(header_.format_version()) + " by hapticd " +
                         header_.server_version() + "; this one reads formats " +
                         std::to_string(kOldestRecordFormat) + " to " +
                         std::to_string(kRecordFormat) + ". Use the version that recorded it.");
  }
}

bool RecordingReader::next(RecordedMessage& message) {
  McapMessage found;
  while (reader_->next(found)) {
    for (std::size_t k = 0; k < kRecordTopics.size(); ++k) {
      if (found.channel == 0 || found.channel != reader_->channel_of(kRecordTopics[k])) continue;
      message = {static_cast<RecordKind>(k), found.time_ns, found.data};
      return true;
    }
  }
  return false;
}

RecordingSummary summarise(RecordingReader& reader) {
  RecordingSummary summary;
  RecordedMessage message;
  std::string_view last;
  while (reader.next(message)) {
    if (message.kind != RecordKind::kTick) continue;
    ++summary.ticks;
    last = message.data;
  }
  v1::TickRecord tick;
  if (tick.ParseFromArray(last.data(), static_cast<int>(last.size()))) {
    summary.last_tick = tick.tick();
  }
  summary.complete = reader.complete();
  summary.end = reader.describe_end();
  reader.rewind();
  return summary;
}

}  // namespace hapticd
