// Records what the haptic loop did, on the recorder's thread: always into a ring in memory of the
// last 60 s (the flight recorder), and into a file when a whole session is asked for. Messages are
// those of recording.proto, one channel each, times those of the loop's clock plus an offset. The
// order of calls: begin() once, then add() and tick() as things happen, poll() at least every 50
// ms. Nothing here stops the loop, and nothing but want of memory is thrown, before anything is
// recorded: what else goes wrong is in status(). Not RT.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <string_view>

#include "core/tick/tick.h"
#include "hapticd/v1/recording.pb.h"
#include "proto/recording/mcap_writer.h"
#include "proto/recording/recording_format.h"
#include "server/encoding/scene_index.h"

namespace hapticd {

struct RecorderOptions {
  std::uint64_t flight_ns = 60'000'000'000;  ///< kept in memory
  /// Most memory of the ring, bytes; reached, it keeps less than flight_ns. A tick of one tool has
  /// about 0.7 kB, 1 kB in touch: 40 to 60 MB for 60 s at 1 kHz.
  std::size_t flight_bytes = 256U << 20U;
  std::uint64_t flush_ns = 50'000'000;  ///< age at which what is written goes to the file
  std::int64_t time_offset_ns = 0;      ///< from the loop's clock to the time in the file
};

struct RecordStatus {
  bool recording = false;
  std::string file;              ///< of the session that runs or ran last
  std::uint64_t ticks = 0;       ///< of it that are in the file
  std::uint64_t bytes = 0;       ///< of the file
  std::uint64_t lost_ticks = 0;  ///< of it that are not, and never will be
  std::string error;             ///< for people; empty: all is well
};

class Recorder {
 public:
  explicit Recorder(const RecorderOptions& options = {});

  /// What every file begins with. A recorder that was not begun records nothing.
  void begin(const v1::RecordHeader& header);

  /// A message of this kind, all but ticks, in the order of the loop; `t_ns` on the loop's clock.
  void add(RecordKind kind, std::uint64_t t_ns, const google::protobuf::Message& record);
  /// `index` is that of the tick's scene; null: not known, and what clients are shown is left out.
  void tick(const Tick& tick, const SceneIndex* index);
  /// Ticks that came too fast for the ring to this thread, or that there was no memory for: counted
  /// as lost.
  void lost_ticks(std::uint64_t count);

  /// Begins a session file, with the scene in force, in folders that are made where they are
  /// missing; false when it cannot be created or begun, which leaves no file, or one runs.
  /// A replay of it starts at the next Snapshot, or at the first tick when it starts with the
  /// scene.
  bool start(const std::string& path);
  /// Ends it, with its summary.
  void stop();
  /// A session could not be begun for want of memory.
  void refuse_start();
  /// Writes the ring to a separate file: header, scene in force, then from the oldest Snapshot it
  /// holds on. False with `error`. Takes about 0.1 s for 60 s.
  bool dump(const std::string& path, std::string& error) const;

  /// Flushes what is older than flush_ns; `now_ns` on any steady clock, always the same.
  void poll(std::uint64_t now_ns);

  [[nodiscard]] RecordStatus status() const;

 private:
  struct Entry {
    RecordKind kind;
    std::uint64_t t_ns;
    std::uint64_t ran_ns;  ///< how long ticks had run then
    std::string bytes;
  };
  struct Session {
    McapWriter writer;
    std::string path;
    std::uint64_t ticks = 0;
    std::uint64_t safe_ticks = 0;  ///< of them, in the file
    std::uint64_t lost = 0;
    std::uint64_t flushed_ns = 0;
  };

  bool add(RecordKind kind, std::uint64_t t_ns, std::string bytes);
  void drop_oldest();
  void forget_old();
  bool write(McapWriter& writer, RecordKind kind, std::uint64_t t_ns, std::string_view bytes) const;
  /// Creates the file, and the folders it is in, and begins it. Returns what went wrong, and leaves
  /// nothing then; empty: nothing.
  std::string begin_file(McapWriter& writer, const std::string& path, std::uint64_t t_ns,
                         std::string_view scene) const;
  /// What every file begins with; false where it is not in the file.
  bool write_beginning(McapWriter& writer, std::uint64_t t_ns, std::string_view scene) const;
  static void flush(Session& session);
  static void note_safe(Session& session) noexcept;
  /// Ticks of a session that are in no file.
  [[nodiscard]] static std::uint64_t lost_of(const Session& session) noexcept;

  RecorderOptions options_;
  std::string header_;        ///< serialised; empty: not begun
  std::string scene_;         ///< in force now
  std::string flight_scene_;  ///< in force at the front of the ring
  std::deque<Entry> flight_;
  std::deque<std::uint64_t> snapshots_;  ///< `ran_ns` of those in the ring
  /// Time that ticks have run for, of all scenes: virtual time begins again with each.
  std::uint64_t ran_ns_ = 0;
  std::uint64_t tick_ns_ = 0;  ///< time of the last tick
  std::size_t flight_bytes_ = 0;
  v1::TickRecord tick_;  ///< memory of the last one
  std::unique_ptr<Session> session_;
  RecordStatus last_;  ///< of the session that ran last
};

}  // namespace hapticd
