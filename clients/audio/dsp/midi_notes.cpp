// See midi_notes.h.
#include "clients/audio/dsp/midi_notes.h"

#include <algorithm>

namespace hapticd::audio {
namespace {

constexpr std::uint8_t kNoteOn = 0x90;
constexpr std::uint8_t kNoteOff = 0x80;

/// Leaves room for `spare` more.
bool append(MidiEvents& out, const MidiEvent& event, std::size_t spare) noexcept {
  if (out.count + spare >= MidiEvents::kMax) return false;
  out.events[out.count++] = event;
  return true;
}

MidiEvent event(std::uint8_t kind, const MidiNote& note, std::uint8_t velocity,
                std::int32_t frame) noexcept {
  return {frame, {static_cast<std::uint8_t>(kind | note.channel), note.number, velocity}};
}

}  // namespace

void MidiNotes::begin(const Strike& strike, std::int32_t frame, MidiEvents& out) noexcept {
  end(strike.string, frame, out);
  const auto place =
      std::find_if(notes_.begin(), notes_.end(), [](const Note& note) { return !note.used; });
  if (place == notes_.end()) return;
  // Room is left for the end of every note.
  if (!append(out, event(kNoteOn, strike.note, strike.note.velocity, frame), kNotes)) return;
  *place = {true, strike.string, strike.note, frame + strike.frames};
}

void MidiNotes::end(std::int32_t string, std::int32_t frame, MidiEvents& out) noexcept {
  for (Note& note : notes_) {
    if (!note.used || note.string != string) continue;
    if (append(out, event(kNoteOff, note.note, 0, frame), 0)) note.used = false;
  }
}

void MidiNotes::advance(std::int32_t frames, MidiEvents& out) noexcept {
  for (Note& note : notes_) {
    if (!note.used) continue;
    note.left -= frames;
    if (note.left <= 0 && append(out, event(kNoteOff, note.note, 0, std::max(frames - 1, 0)), 0)) {
      note.used = false;
    }
  }
}

}  // namespace hapticd::audio
