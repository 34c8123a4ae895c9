// See render.h.
#include "clients/audio/render.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "clients/audio/audio_engine.h"
#include "clients/audio/body_design.h"
#include "clients/audio/sound_file.h"

namespace hapticd::audio {
namespace {

/// A tone file: length, decay and level. Ours; the level leaves room for the crest of the sound.
constexpr double kToneLength_s = 5.0;
constexpr double kToneDecay_s = 0.5;
constexpr double kToneLambda = 0.1;
/// The end of a file is faded, so that it does not click, s.
constexpr double kFade_s = 0.05;

/// The frame at which what it tells of has died away.
std::int64_t end_of(const ScoreEntry& entry, double rate_hz) {
  auto decay_s = static_cast<double>(entry.item.tone().decay_s());
  for (const float each : entry.item.string_sounding().decays_s()) {
    decay_s = std::max(decay_s, static_cast<double>(each));
  }
  const double life_s = std::min(kLifeInDecays * decay_s, kMaxTail_s);
  return static_cast<std::int64_t>((static_cast<double>(entry.t_ns) * 1e-9 + life_s) * rate_hz);
}

std::size_t frames_left(std::int64_t frame, std::int64_t end) {
  return end > frame ? static_cast<std::size_t>(end - frame) : 0;
}

}  // namespace

RenderReport render(const Score& score, const Sound& sound, ToneFiles* tones,
                    const std::function<void(std::span<const float>)>& write, std::size_t block) {
  const auto engine = std::make_unique<AudioEngine>(sound.body);
  EventPlayer player(sound, tones, [&](const Order& order) { return engine->submit(order); });
  const FrameClock clock{0, 0, 1e9 / sound.rate_hz};
  std::vector<float> frames(block);
  MidiEvents notes;
  std::int64_t frame = 0;
  std::size_t next = 0;
  std::int64_t end = 0;
  while (next < score.size() || frame < end) {
    // Orders wait in the engine no longer than a block; a thousand in a block find room.
    const auto block_end = frame + static_cast<std::int64_t>(block);
    const auto due_before =
        static_cast<std::int64_t>(static_cast<double>(block_end) * clock.ns_per_frame);
    for (; next < score.size() && score[next].t_ns < due_before; ++next) {
      const ScoreEntry& entry = score[next];
      if (entry.item.has_scene_info()) player.set_scene(entry.item.scene_info().scene());
      player.play(entry.item, entry.t_ns);
      if (!entry.item.has_tone() && !entry.item.has_string_sounding()) continue;
      end = std::max(end, end_of(entry, sound.rate_hz));
    }
    const std::size_t count =
        next < score.size() ? block : std::min(block, frames_left(frame, end));
    engine->render(clock, frame, std::span(frames).first(count), notes);
    write(std::span<const float>(frames).first(count));
    frame += static_cast<std::int64_t>(count);
  }
  return {static_cast<double>(frame) / sound.rate_hz, player.counts(), engine->counts().played,
          engine->counts().stolen, static_cast<double>(engine->counts().limited) / sound.rate_hz};
}

void render_tone_files(const std::string& folder, double rate_hz) {
  std::filesystem::create_directories(folder);
  Sound sound{rate_hz, 1.0, design_body(rate_hz)};
  for (const OpenString& open : kZhengDiao) {
    ToneSound tone;
    tone.frequency_hz = open.frequency_hz;
    tone.level = 1.0;
    tone.lambda = kToneLambda;
    tone.decay_s = kToneDecay_s;
    const auto strike = design_string(tone, sound);
    if (!strike)
      throw std::runtime_error(std::string(open.name) + " cannot be computed at this sample rate");
    const auto synthesizer = std::make_unique<Synthesizer>(sound.body);
    synthesizer->start(*strike);
    std::vector<float> frames(static_cast<std::size_t>(kToneLength_s * rate_hz));
    synthesizer->render(frames);
    const auto fade = static_cast<std::size_t>(kFade_s * rate_hz);
    for (std::size_t i = 0; i < fade; ++i) {
      frames[frames.size() - 1 - i] *= static_cast<float>(i) / static_cast<float>(fade);
    }
    SoundFile file(std::filesystem::path(folder) / (std::string(open.name) + ".flac"), rate_hz,
                   open.frequency_hz);
    file.write(frames);
  }
}

}  // namespace hapticd::audio
