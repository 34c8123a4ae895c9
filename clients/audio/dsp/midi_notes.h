// The same tones as MIDI notes, for instruments that speak it: a note begins with its tone and ends
// when the string is damped, plucked again, or has died away. RT: yes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "clients/audio/dsp/strike.h"

namespace hapticd::audio {

/// A MIDI message of three bytes, in a block.
struct MidiEvent {
  std::int32_t frame = 0;  ///< of the block
  std::array<std::uint8_t, 3> bytes{};
};

/// Those of one block, in order; what does not fit is left out, but never the end of a note.
struct MidiEvents {
  static constexpr std::size_t kMax = 128;
  std::array<MidiEvent, kMax> events{};
  std::size_t count = 0;
};

/// Notes that sound.
class MidiNotes {
 public:
  /// A tone begins at `frame` of the block.
  void begin(const Strike& strike, std::int32_t frame, MidiEvents& out) noexcept;
  /// The tone of `string` is ended by a finger.
  void end(std::int32_t string, std::int32_t frame, MidiEvents& out) noexcept;
  /// A block of `frames` is over; notes that die away in it end with it.
  void advance(std::int32_t frames, MidiEvents& out) noexcept;

 private:
  static constexpr std::size_t kNotes = 32;
  struct Note {
    bool used = false;
    std::int32_t string = 0;
    MidiNote note;
    std::int64_t left = 0;  ///< frames
  };

  std::array<Note, kNotes> notes_{};
};

}  // namespace hapticd::audio
