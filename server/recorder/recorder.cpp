// See recorder.h.
#include "server/recorder/recorder.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <new>
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
  const bool written =
      add(RecordKind::kTick, static_cast<std::uint64_t>(tick.t_ns), tick_.SerializeAsString());
  if (!session_) return;
  // Those after an error are told apart by what is safe.
  if (written || !session_->writer.error().empty()) {
    ++session_->ticks;
  } else {
    ++session_->lost;
  }
}

void Recorder::lost_ticks(std::uint64_t count) {
  if (session_) session_->lost += count;
}

bool Recorder::write(McapWriter& writer, RecordKind kind, std::uint64_t t_ns,
                     std::string_view bytes) const {
  return writer.write(static_cast<std::uint16_t>(static_cast<int>(kind) + 1),
                      t_ns + static_cast<std::uint64_t>(options_.time_offset_ns), bytes);
}

// What asks for memory comes first: then either all of it is kept, or nothing.
bool Recorder::add(RecordKind kind, std::uint64_t t_ns, std::string bytes) {
  if (header_.empty()) return false;
  const bool is_tick = kind == RecordKind::kTick;
  const std::uint64_t now_ns = is_tick ? t_ns : tick_ns_;
  const std::uint64_t last_ns = ran_ns_ + (is_tick && t_ns > tick_ns_ ? t_ns - tick_ns_ : 0);
  const std::uint64_t ran_ns = last_ns + (t_ns > now_ns ? t_ns - now_ns : 0);
  std::string scene = kind == RecordKind::kScene ? bytes : std::string();
  flight_.push_back({kind, t_ns, ran_ns, std::move(bytes)});
  try {
    if (kind == RecordKind::kSnapshot) snapshots_.push_back(ran_ns);
  } catch (const std::bad_alloc&) {
    flight_.pop_back();
    throw;
  }
  if (kind == RecordKind::kScene) scene_ = std::move(scene);
  tick_ns_ = now_ns;
  ran_ns_ = last_ns;
  const std::string& kept = flight_.back().bytes;
  flight_bytes_ += kept.size() + kEntryBytes;
  const bool written = session_ && write(session_->writer, kind, t_ns, kept);
  forget_old();
  return written;
}

void Recorder::drop_oldest() {
  Entry& oldest = flight_.front();
  flight_bytes_ -= oldest.bytes.size() + kEntryBytes;
  if (oldest.kind == RecordKind::kScene) flight_scene_ = std::move(oldest.bytes);
  if (oldest.kind == RecordKind::kSnapshot) snapshots_.pop_front();
  flight_.pop_front();
}

void Recorder::forget_old() {
  const auto older = [this](std::uint64_t ran_ns, std::uint64_t age_ns) {
    return ran_ns < ran_ns_ && ran_ns_ - ran_ns >= age_ns;
  };
  // The ring begins with the youngest Snapshot that is old enough: there a replay can start.
  const auto front_is_snapshot = [this] { return flight_.front().kind == RecordKind::kSnapshot; };
  for (;;) {
    const std::size_t next = front_is_snapshot() ? 1 : 0;
    if (snapshots_.size() <= next || !older(snapshots_[next], options_.flight_ns)) break;
    do drop_oldest();
    while (!front_is_snapshot());
  }
  while (older(flight_.front().ran_ns, options_.flight_ns + kGrace_ns)) drop_oldest();
  if (flight_bytes_ <= options_.flight_bytes) return;
  while (flight_.size() > 1 && flight_bytes_ > options_.flight_bytes) drop_oldest();
  while (!snapshots_.empty() && !front_is_snapshot()) drop_oldest();
}

std::string Recorder::begin_file(McapWriter& writer, const std::string& path, std::uint64_t t_ns,
                                 std::string_view scene) const {
  MadeFolders folders(path);
  if (!folders.error().empty()) return folders.error();
  bool whole = false;
  try {
    whole = writer.open(path, kLibrary) && write_beginning(writer, t_ns, scene);
  } catch (const std::bad_alloc&) {
    whole = false;
  }
  if (whole) {
    folders.keep();
    return "";
  }
  std::string error = writer.error().empty() ? "out of memory" : writer.take_error();
  if (writer.is_open()) {
    writer.close();
    ::unlink(path.c_str());
  }
  return error;
}

bool Recorder::write_beginning(McapWriter& writer, std::uint64_t t_ns,
                               std::string_view scene) const {
  const auto types = record_types();
  for (std::size_t k = 0; k < types.size(); ++k) {
    writer.add_channel(kRecordTopics[k], types[k]->full_name(), schema_set(*types[k]));
  }
  if (!write(writer, RecordKind::kHeader, t_ns, header_)) return false;
  if (!scene.empty() && !write(writer, RecordKind::kScene, t_ns, scene)) return false;
  writer.flush();
  return writer.flushed() && writer.error().empty();
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

void Recorder::refuse_start() {
  last_.file.clear();
  last_.error = "out of memory";
}

void Recorder::flush(Session& session) {
  session.writer.flush();
  note_safe(session);
}

void Recorder::note_safe(Session& session) noexcept {
  const McapWriter& writer = session.writer;
  if (writer.error().empty() && writer.flushed()) session.safe_ticks = session.ticks;
}

std::uint64_t Recorder::lost_of(const Session& session) noexcept {
  const bool failed = !session.writer.error().empty();
  return session.lost + (failed ? session.ticks - session.safe_ticks : 0);
}

// Nothing here asks for memory that it cannot do without: a session ends when it is told to.
void Recorder::stop() {
  if (!session_) return;
  flush(*session_);
  session_->writer.close();
  note_safe(*session_);
  last_.recording = false;
  last_.ticks = session_->safe_ticks;
  last_.bytes = session_->writer.bytes();
  last_.lost_ticks = lost_of(*session_);
  last_.file = std::move(session_->path);
  last_.error = session_->writer.take_error();
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
  const bool closed = writer.close();
  if (closed && writer.lost() == 0) return true;
  error = closed ? "out of memory" : writer.take_error();
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
  status.lost_ticks = lost_of(*session_);
  status.error = error;
  return status;
}

}  // namespace hapticd
