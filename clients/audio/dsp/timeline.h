// Plays what is due, when it is due: orders come with the instant at which they are to be heard, in
// ns of one clock; blocks of frames come with the instant at which their frames are heard. An order
// begins with the frame nearest to its instant. One whose instant is over when it comes is played
// at once and counted as late: none is ever dropped. RT: yes.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "clients/audio/dsp/midi_notes.h"
#include "clients/audio/dsp/strike.h"
#include "clients/audio/dsp/synthesizer.h"

namespace hapticd::audio {

/// Something to be done at an instant.
struct Order {
  enum class Kind : std::uint8_t { kStrike, kChange, kTelling };
  std::int64_t due_ns = 0;
  Kind kind = Kind::kStrike;
  Change change;    ///< kChange
  Telling telling;  ///< kTelling
  Strike strike;    ///< kStrike; kTelling: what is told, as a voice that would begin with it
};

/// The relation of the output's frames to the clock of due_ns.
struct FrameClock {
  std::int64_t frame = 0;     ///< some frame of the output, counted from its start
  std::int64_t heard_ns = 0;  ///< when it is heard
  double ns_per_frame = 1e9 / 48000;
};

/// What has happened so far; read from any thread.
struct PlayCounts {
  std::atomic<std::uint64_t> played{0};    ///< tones begun
  std::atomic<std::uint64_t> late{0};      ///< of them, after their instant
  std::atomic<std::int64_t> latest_ns{0};  ///< by how much at most
  std::atomic<std::uint64_t> stolen{0};    ///< tones ended for others
  std::atomic<std::uint64_t> broken{0};    ///< tones ended since they gave no numbers
  std::atomic<std::uint64_t> limited{0};   ///< frames made softer
};

/// Orders that wait. More wait in the ring before it.
inline constexpr std::size_t kWaiting = 256;

class Timeline {
 public:
  explicit Timeline(const BodyFilter& body) noexcept : synthesizer_(body) {}

  /// There is room for another order.
  [[nodiscard]] bool has_room() const noexcept { return waiting_ < kWaiting; }
  /// An order to be played. Precondition: has_room(). Those of one instant keep their order.
  void add(const Order& order) noexcept;
  /// The next frames; `first_frame` is the number of out[0]. What happens to notes is written to
  /// `notes`.
  void render(const FrameClock& clock, std::int64_t first_frame, std::span<float> out,
              MidiEvents& notes) noexcept;

  [[nodiscard]] const PlayCounts& counts() const noexcept { return counts_; }
  [[nodiscard]] const Synthesizer& synthesizer() const noexcept { return synthesizer_; }

 private:
  void play(const Order& order, std::int64_t late_frames, double ns_per_frame, std::int32_t offset,
            MidiEvents& notes) noexcept;

  Synthesizer synthesizer_;
  MidiNotes notes_;
  std::array<Order, kWaiting> orders_{};
  std::array<std::uint16_t, kWaiting> queue_{};  ///< places in orders_, the first due at the end
  std::array<std::uint16_t, kWaiting> free_{};   ///< places that are not in use
  std::size_t waiting_ = 0;
  std::size_t freed_ = 0;  ///< entries of free_
  std::size_t used_ = 0;   ///< places of orders_ ever used
  PlayCounts counts_;
};

}  // namespace hapticd::audio
