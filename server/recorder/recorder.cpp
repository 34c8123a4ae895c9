// See recorder.h.
#include "server/recorder/recorder.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "proto/recording/schema_set.h"
#include "server/recorder/tick_record.h"

namespace hapticd {
namespace {

constexpr std::string_view kLibrary = "hapticd";
/// Memory of an entry beside its bytes: itself and what the heap adds.
constexpr std::size_t kEntryBytes = 64;
/// Without Snapshots (a loop that makes none) the ring still ends: this much later.
constexpr std::uint64_t kGrace_ns = 5'000'000'000;

/// In the order of RecordKind.
std::array<const google::protobuf::Descriptor*, kRecordTopics.size()> record_types() {
  return {v1::RecordHeader::descriptor(),    v1::SceneRecord::descriptor(),
          v1::ParameterRecord::descriptor(), v1::TickRecord::descriptor(),
          v1::EventRecord::descriptor(),     v1::Snapshot::descriptor()};
}

/// The folders a file is in, made where they are missing; unless kept, those are removed again.
class MadeFolders {
 public:
  explicit MadeFolders(const std::filesystem::path& file) {
    // A bare name has no parent: it is in the folder of the process.
    for (auto folder = file.parent_path(); !folder.empty(); folder = folder.parent_path()) {
      std::error_code ignored;
      if (std::filesystem::exists(folder, ignored) || folder == folder.parent_path()) break;
      made_.push_back(folder);
    }
    if (made_.empty()) return;
    std::error_code error;
    std::filesystem::create_directories(made_.front(), error);
    if (error) error_ = made_.front().string() + ": " + error.message();
  }
  MadeFolders(const MadeFolders&) = delete;
  MadeFolders& operator=(const MadeFolders&) = delete;
  ~MadeFolders() {
    std::error_code ignored;  // one that is not empty by now stays
    for (const auto& folder : made_) std::filesystem::remove(folder, ignored);
  }

  void keep() { made_.clear(); }
  [[nodiscard]] const std::string& error() const { return error_; }

 private:
  std::vector<std::filesystem::path> made_;  ///< innermost first
  std::string error_;
};

}  // namespace

Recorder::Recorder(const RecorderOptions& options) : options_(options) {}

void Recorder::begin(const v1::RecordHeader& header) {
  v1::RecordHeader versioned = header;
  versioned.set_format_version(kRecordFormat);
  header_ = versioned.SerializeAsString();
}

void Recorder::add(RecordKind kind, std::uint64_t t_ns, const google::protobuf::Message& record) {
  add(kind, t_ns, record.SerializeAsString());
}

void Recorder::tick(const Tick& tick, const SceneIndex* index) {
  to_record(tick, tick_);
  if (index != nullptr) add_shown(tick, *index, tick_);
  if (session_) ++session_->ticks;
  add(RecordKind::kTick, static_cast<std::uint64_t>(tick.t_ns), tick_.SerializeAsString());
}

void Recorder::lost_ticks(std::uint64_t count) {
  if (session_) session_->lost += count;
}

void Recorder::write(McapWriter& writer, RecordKind kind, std::uint64_t t_ns,
                     std::string_view bytes) const {
  writer.write(static_cast<std::uint16_t>(static_cast<int>(kind) + 1),
               t_ns + static_cast<std::uint64_t>(options_.time_offset_ns), bytes);
}

void Recorder::add(RecordKind kind, std::uint64_t t_ns, std::string bytes) {
  if (header_.empty()) return;
  if (session_) write(session_->writer, kind, t_ns, bytes);
  if (kind == RecordKind::kScene) scene_ = bytes;
  if (kind == RecordKind::kSnapshot) snapshots_.push_back(t_ns);
  flight_bytes_ += bytes.size() + kEntryBytes;
  flight_.push_back({kind, t_ns, std::move(bytes)});
  forget_old();
}

void Recorder::drop_oldest() {
  Entry& oldest = flight_.front();
  flight_bytes_ -= oldest.bytes.size() + kEntryBytes;
  if (oldest.kind == RecordKind::kScene) flight_scene_ = std::move(oldest.bytes);
  if (oldest.kind == RecordKind::kSnapshot) snapshots_.pop_front();
  flight_.pop_front();
}

void Recorder::forget_old() {
  const std::uint64_t now_ns = flight_.back().t_ns;
  const auto older = [now_ns](std::uint64_t t_ns, std::uint64_t age_ns) {
    return t_ns < now_ns && now_ns - t_ns >= age_ns;
  };
  // The ring begins with the youngest Snapshot that is old enough: there a replay can start.
  const auto front_is_snapshot = [this] { return flight_.front().kind == RecordKind::kSnapshot; };
  for (;;) {
    const std::size_t next = front_is_snapshot() ? 1 : 0;
    if (snapshots_.size() <= next || !older(snapshots_[next], options_.flight_ns)) break;
    do drop_oldest();
    while (!front_is_snapshot());
  }
  while (older(flight_.front().t_ns, options_.flight_ns + kGrace_ns)) drop_oldest();
  if (flight_bytes_ <= options_.flight_bytes) return;
  while (flight_.size() > 1 && flight_bytes_ > options_.flight_bytes) drop_oldest();
  while (!snapshots_.empty() && !front_is_snapshot()) drop_oldest();
}

std::string Recorder::begin_file(McapWriter& writer, const std::string& path, std::uint64_t t_ns,
                                 std::string_view scene) const {
  MadeFolders folders(path);
  if (!folders.error().empty()) return folders.error();
  if (writer.open(path, kLibrary)) {
    const auto types = record_types();
    for (std::size_t k = 0; k < types.size(); ++k) {
      writer.add_channel(kRecordTopics[k], types[k]->full_name(), schema_set(*types[k]));
    }
    write(writer, RecordKind::kHeader, t_ns, header_);
    if (!scene.empty()) write(writer, RecordKind::kScene, t_ns, scene);
    writer.flush();
  }
  const std::string error = writer.error();
  if (error.empty()) {
    folders.keep();
  } else if (writer.is_open()) {
    writer.close();
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
  return error;
}

bool Recorder::start(const std::string& path) {
  if (session_) return false;
  last_ = {};
  last_.file = path;
  if (header_.empty()) {
    last_.error = path + ": nothing to record yet";
    return false;
  }
  auto session = std::make_unique<Session>();
  session->path = path;
  const std::uint64_t t_ns = flight_.empty() ? 0 : flight_.back().t_ns;
  last_.error = begin_file(session->writer, path, t_ns, scene_);
  if (!last_.error.empty()) return false;
  session_ = std::move(session);
  return true;
}

void Recorder::flush(Session& session) {
  session.writer.flush();
  if (session.writer.error().empty()) session.safe_ticks = session.ticks;
}

void Recorder::stop() {
  if (!session_) return;
  flush(*session_);
  session_->writer.close();
  last_ = status();
  last_.recording = false;
  session_.reset();
}

void Recorder::poll(std::uint64_t now_ns) {
  if (!session_) return;
  if (now_ns - session_->flushed_ns < options_.flush_ns) return;
  session_->flushed_ns = now_ns;
  flush(*session_);
}

bool Recorder::dump(const std::string& path, std::string& error) const {
  if (header_.empty() || flight_.empty()) {
    error = path + ": nothing was recorded yet";
    return false;
  }
  McapWriter writer;
  error = begin_file(writer, path, flight_.front().t_ns, flight_scene_);
  if (!error.empty()) return false;
  for (const Entry& entry : flight_) {
    if (!writer.error().empty()) break;
    write(writer, entry.kind, entry.t_ns, entry.bytes);
  }
  if (writer.close()) return true;
  error = writer.error();
  return false;
}

RecordStatus Recorder::status() const {
  if (!session_) return last_;
  const std::string& error = session_->writer.error();
  RecordStatus status;
  status.recording = error.empty();
  status.file = session_->path;
  status.ticks = session_->safe_ticks;
  status.bytes = session_->writer.bytes();
  status.lost_ticks = session_->lost;
  if (!error.empty()) status.lost_ticks += session_->ticks - session_->safe_ticks;
  status.error = error;
  return status;
}

}  // namespace hapticd
