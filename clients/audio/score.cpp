// See score.h.
#include "clients/audio/score.h"

#include <algorithm>
#include <optional>

#include "clients/library/recording.h"

namespace hapticd::audio {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

std::optional<std::uint64_t> instant_of(const v1::Item& item) {
  if (item.has_tone()) return item.tone().t_ns();
  if (item.has_string_radius()) return item.string_radius().t_ns();
  if (item.has_string_sounding()) return item.string_sounding().t_ns();
  return std::nullopt;
}

template <typename Message>
std::optional<Message> parsed(const RecordedMessage& from) {
  std::optional<Message> message(std::in_place);
  if (!message->ParseFromArray(from.data.data(), static_cast<int>(from.data.size()))) return {};
  return message;
}

ScoreEntry tone_at(std::int64_t t_ns, std::uint32_t string, float level) {
  ScoreEntry entry{t_ns, {}};
  v1::Tone& tone = *entry.item.mutable_tone();
  tone.set_t_ns(static_cast<std::uint64_t>(t_ns));
  tone.set_string_index(string);
  tone.set_frequency_hz(static_cast<float>(kZhengDiao[string].frequency_hz));
  tone.set_level(level);
  tone.set_lambda(0.1F);
  tone.set_decay_s(1.0F);
  return entry;
}

}  // namespace

Score open_strings() {
  Score score(1);
  v1::Scene& scene = *score[0].item.mutable_scene_info()->mutable_scene();
  for (const OpenString& open : kZhengDiao) {
    v1::String& string = *scene.add_strings();
    string.set_name(open.name);
    string.set_frequency_hz(open.frequency_hz);
  }
  constexpr std::uint32_t kCount = std::size(kZhengDiao);
  for (std::uint32_t i = 0; i < kCount; ++i) score.push_back(tone_at(i * kSecond_ns, i, 0.7F));
  for (std::uint32_t i = 0; i < kCount; ++i) {
    score.push_back(tone_at(kCount * kSecond_ns + i * kSecond_ns / 14, i, 0.5F));
  }
  return score;
}

Score recorded_score(const std::string& path, std::string& problem) {
  const client::Recording recording(path);
  Score score;
  std::optional<std::int64_t> begin;  // of the score, on the recording's clock
  std::int64_t last = 0;
  bool knows_scene = false;
  bool whole = recording.whole();
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const RecordedMessage& message = recording[i];
    if (message.kind == RecordKind::kScene) {
      const auto scene = parsed<v1::SceneRecord>(message);
      whole = whole && scene.has_value();
      if (!scene) continue;
      ScoreEntry entry{last, {}};
      *entry.item.mutable_scene_info()->mutable_scene() = scene->scene();
      // Ticks of virtual time may be written before the scene that they are of.
      if (!knows_scene) entry.t_ns = 0;
      score.insert(knows_scene ? score.end() : score.begin(), entry);
      knows_scene = true;
    }
    if (message.kind != RecordKind::kEvent) continue;
    const auto event = parsed<v1::EventRecord>(message);
    whole = whole && event.has_value();
    const std::optional<std::uint64_t> instant = event ? instant_of(event->item()) : std::nullopt;
    if (!instant) continue;
    const auto t_ns = static_cast<std::int64_t>(std::min<std::uint64_t>(*instant, INT64_MAX));
    // Events of one tick may be in another order; further back is another scene's time.
    if (!begin || t_ns - *begin < last - kSecond_ns) begin = t_ns - last;
    const std::int64_t at = std::max<std::int64_t>(t_ns - *begin, 0);
    last = std::max(last, at);
    score.push_back({at, event->item()});
  }
  if (!whole) problem = "it is not whole: cut off, damaged or compressed. The rest is played";
  return score;
}

}  // namespace hapticd::audio
