// See playing.h.
#include "clients/audio/playing.h"

#include <algorithm>

#include "clients/audio/body_design.h"
#include "clients/audio/live.h"

namespace hapticd::audio {
namespace {

/// Events that are kept for another sample rate; more than wait within the longest delay of 1 s.
constexpr std::size_t kMaxWaiting = 1024;

void add(const PlayedTones& more, PlayedTones& sum) {
  sum.unplayable += more.unplayable;
  sum.lost += more.lost;
  sum.played += more.played;
  sum.late += more.late;
  sum.stolen += more.stolen;
  sum.broken += more.broken;
  sum.latest_ms = std::max(sum.latest_ms, more.latest_ms);
  sum.limited_s += more.limited_s;
}

}  // namespace

Instrument::Instrument(double rate_hz, double gain, const std::string& folder)
    : sound{rate_hz, gain, design_body(rate_hz)},
      engine(sound.body, rate_hz),
      tones(folder.empty() ? nullptr : std::make_unique<ToneFiles>(folder, rate_hz)),
      player(sound, tones.get(), [this](const Order& order) { return engine.submit(order); }) {}

Playing::Playing(const Options& options, std::string folder)
    : gain_(gain_of(options)),
      folder_(std::move(folder)),
      output_(std::make_unique<JackOutput>(options.name)),
      instrument_(std::make_unique<Instrument>(output_->rate_hz(), gain_, folder_)) {
  output_->play(instrument_->engine);
  output_->start();
}

// The callback ends before what it plays.
Playing::~Playing() { output_.reset(); }

std::vector<std::string> Playing::connect(const Options& options) {
  if (options.no_connect) return {};
  return output_->connect(options.connect);
}

void Playing::set_scene(const v1::Scene& scene) {
  scene_ = scene;
  instrument_->player.set_scene(scene);
}

void Playing::play(const v1::Item& event, std::int64_t due_ns, std::int64_t now_ns) {
  if (event.has_tone()) ++tones_;
  instrument_->player.play(event, due_ns);
  std::erase_if(waiting_, [&](const auto& each) { return each.first <= now_ns; });
  if (waiting_.size() >= kMaxWaiting) waiting_.pop_front();
  waiting_.emplace_back(due_ns, event);
}

bool Playing::follow_rate(std::int64_t now_ns) {
  bury();
  const double rate_hz = output_->rate_hz();
  if (rate_hz == instrument_->sound.rate_hz) return false;
  auto next = std::make_unique<Instrument>(rate_hz, gain_, folder_);
  if (scene_) next->player.set_scene(*scene_);
  problems_said_ = notes_said_ = 0;
  for (const auto& [due_ns, event] : waiting_) {
    if (due_ns > now_ns) next->player.play(event, due_ns);
  }
  output_->play(next->engine);
  former_.push_back(std::exchange(instrument_, std::move(next)));
  return true;
}

void Playing::bury() {
  if (!output_->plays(instrument_->engine)) return;
  for (const auto& each : former_) add(counts_of(*each), buried_);
  former_.clear();
}

std::vector<std::string> Playing::remarks() {
  std::vector<std::string> lines;
  if (!instrument_->tones) return lines;
  const auto& problems = instrument_->tones->problems();
  for (; problems_said_ < problems.size(); ++problems_said_) {
    lines.push_back(problems[problems_said_] + ". The string is computed instead");
  }
  const auto& notes = instrument_->tones->notes();
  for (; notes_said_ < notes.size(); ++notes_said_) lines.push_back(notes[notes_said_]);
  return lines;
}

PlayedTones Playing::counts_of(const Instrument& instrument) {
  const EventCounts& events = instrument.player.counts();
  const PlayCounts& counts = instrument.engine.counts();
  PlayedTones found;
  found.unplayable = events.unplayable;
  found.lost = events.lost;
  found.played = counts.played.load();
  found.late = counts.late.load();
  found.stolen = counts.stolen.load();
  found.broken = counts.broken.load();
  found.latest_ms = static_cast<double>(counts.latest_ns.load()) * 1e-6;
  found.limited_s = static_cast<double>(counts.limited.load()) / instrument.sound.rate_hz;
  return found;
}

PlayedTones Playing::counts() const {
  PlayedTones sum = buried_;
  sum.tones = tones_;
  for (const auto& each : former_) add(counts_of(*each), sum);
  add(counts_of(*instrument_), sum);
  return sum;
}

}  // namespace hapticd::audio
