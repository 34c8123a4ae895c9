// See string_players.h. RT: yes.
#include "core/simulation/string_players.h"

#include <algorithm>

#include "core/simulation/touch_place.h"
#include "core/simulation/wave_player.h"

namespace hapticd {
namespace {

/// Drops what says how the string is drawn: that is for the tool that plays it to say.
void drop_radius_events(std::size_t first, StringEvents& events) noexcept {
  const StringEvent* const kept = std::remove_if(
      events.begin() + first, events.end(),
      [](const StringEvent& event) { return event.kind == StringEventKind::kRadius; });
  events.truncate(static_cast<std::size_t>(kept - events.begin()));
}

}  // namespace

/// What of a string vibrates: the part that is played, between the tools that hold it.
struct StringPlayers::Sounding {
  StringConstants string;
  double from = 0.0;  ///< along the string
  double to = 1.0;

  [[nodiscard]] bool all() const noexcept { return from == 0.0 && to == 1.0; }
  [[nodiscard]] double along_part(double lambda) const noexcept {
    return to > from ? std::clamp((lambda - from) / (to - from), 0.0, 1.0) : 0.5;
  }
  [[nodiscard]] double along_string(double lambda) const noexcept {
    return from + lambda * (to - from);
  }
};

StringPlayers::Sounding StringPlayers::sounding_part(std::int32_t string) const noexcept {
  const auto s = static_cast<std::size_t>(string);
  const PlayedString& track = memory_.tracks[s];
  const ToolPlay& play = memory_.tools[static_cast<std::size_t>(track.player)];
  Sounding sounding{play.scene.strings[s]};
  if (sharing_.empty()) return sounding;
  StringTools tools;
  StringPoints points;
  string_points(string_tools(memory_, tools), sharing_, string, track.player, points);
  if (points.size() == 2) return sounding;
  const Capsule& line = play.scene.obstacles.capsules_W[s];
  std::size_t part = 0;
  while (part + 2 < points.size() && lambda_of(line, points[part + 1]) < track.place) ++part;
  sounding.string = part_constants(play.scene.strings[s], points, part);
  if (part > 0) sounding.from = lambda_of(line, points[part]);
  if (part + 2 < points.size()) sounding.to = lambda_of(line, points[part + 1]);
  return sounding;
}

void StringPlayers::play_string(std::int32_t string, const StringProximity& near,
                                Tick& tick) noexcept {
  const auto s = static_cast<std::size_t>(string);
  PlayedString& track = memory_.tracks[s];
  const auto player = static_cast<std::size_t>(track.player);
  ToolPlay& play = memory_.tools[player];
  const std::size_t first = events_.size();
  StringTouch touch = near.touch;
  const double place = whole_lambda(play.view, string, touch.lambda);
  const bool near_by = near.part >= 0;
  if (near_by && (track.state.detector.touching || touch.distance < 0.0)) track.place = place;
  const Sounding sounding = sounding_part(string);
  if (!sounding.all() || part_of(play.view, string) != nullptr) {
    touch.lambda = sounding.along_part(place);
  }
  // Kept along the whole string: what part of it sounds may change before the touch ends.
  ReleaseDetector& detector = track.state.detector;
  const bool whole = sounding.all();
  if (!whole) detector.lambda = sounding.along_part(detector.lambda);
  const StringResponse response =
      respond({string, sounding.string, play.scene.instrument, track.state}, touch, events_);
  if (!whole) detector.lambda = sounding.along_string(detector.lambda);
  for (std::size_t k = first; k < events_.size() && !whole; ++k) {
    StringEvent& event = events_[k];
    if (event.kind != StringEventKind::kRadius) event.lambda = sounding.along_string(event.lambda);
  }
  ToolStringState& seen = visit(player, string);
  if (near_by) seen.part = near.part;
  const Toucher toucher{play, track.player, string, near.touch.time, seen};
  name_place(first, toucher, events_);
  // What moved without time passing counts as motion of the next tick.
  if (near.touch.time.dt_ns > 0) remember(toucher, near, touched_ns(detector, touch.time), seen);

  // A force held over a tick without a sample may not attract either.
  const double vibration_force = std::max(response.vibration_force, -near.touch.force);
  // Eq. 8 and 9 are of a force: the torque is that of the coupling alone.
  play.rendered.F_computed_H_W.f += vibration_force * near.nhat_W;

  const StringState& state = track.state;
  if (!awake(state)) return;
  StringTick reading;
  reading.string = string;
  reading.phase = state.level;
  reading.touched = state.detector.touching;
  reading.armed = state.detector.armed;
  reading.lambda = reading.touched ? place : sounding.along_string(state.vibration.lambda);
  reading.radius_growth = response.radius_growth;
  reading.vibration_force = vibration_force;
  reading.deflection_W = to_array(near.u_W);
  reading.energy = state.vibration.energy;
  reading.tool = track.player;
  tick.strings.push_back(reading);
  tick.string_energy += reading.energy;
}

// The touch of a tool that does not play the string: as of one that cannot sound.
void StringPlayers::watch_others(std::int32_t string,
                                 std::span<const StringProximity> near) noexcept {
  const auto s = static_cast<std::size_t>(string);
  for (std::size_t tool = 0; tool < near.size(); ++tool) {
    const auto number = static_cast<std::int32_t>(tool);
    if (number == memory_.tracks[s].player) continue;
    const ToolPlay& play = memory_.tools[tool];
    ToolStringState& seen = visit(tool, string);
    const StringTouch& touch = near[tool].touch;
    if (touch.time.dt_ns <= 0) continue;
    const Toucher toucher{play, number, string, touch.time, seen};
    if (seen.detector.touching || touch.distance < 0.0) {
      InstrumentOptions silent = play.scene.instrument;
      silent.vibration = false;
      StringState state;
      state.detector = seen.detector;
      state.detector.lambda = part_lambda(play.view, string, state.detector.lambda);
      const std::size_t first = events_.size();
      static_cast<void>(
          respond({string, play.way.input.strings[s], silent, state}, touch, events_));
      drop_radius_events(first, events_);
      for (std::size_t k = first; k < events_.size(); ++k) {
        events_[k].lambda = whole_lambda(play.view, string, events_[k].lambda);
      }
      if (near[tool].part >= 0) seen.part = near[tool].part;
      name_place(first, toucher, events_);
      seen.detector = state.detector;
      seen.detector.lambda = whole_lambda(play.view, string, state.detector.lambda);
    }
    remember(toucher, near[tool], touched_ns(seen.detector, touch.time), seen);
  }
}

// One that lets go of what it has bent comes first: that plucks. Then whoever plays it goes on
// while it touches. A string that is let go of belongs to who touches it anew, and one that is
// silent to who holds it; what rings over a finger that has been there before goes on ringing.
std::int32_t StringPlayers::choose_player(std::int32_t string,
                                          std::span<const StringProximity> near) const noexcept {
  const auto s = static_cast<std::size_t>(string);
  const PlayedString& track = memory_.tracks[s];
  const auto player = static_cast<std::size_t>(track.player);
  const bool lets_go = track.state.detector.armed && near[player].touch.distance >= 0.0;
  const bool rings = track.state.level >= StringPhase::kFundamental;
  std::int32_t chosen = track.player;
  double nearest = kNotNear;
  for (std::size_t tool = 0; tool < near.size(); ++tool) {
    const auto number = static_cast<std::int32_t>(tool);
    if (number == track.player) continue;
    const ReleaseDetector& detector = visit(tool, string).detector;
    const StringTouch& touch = near[tool].touch;
    if (detector.armed && touch.distance >= 0.0 && !lets_go) return number;
    if (track.state.detector.touching) continue;
    const double reach = envelope(memory_.tools[tool].scene.strings[s], track.state, touch.lambda,
                                  track.state.vibration.t_ns);
    const bool anew = !detector.touching && touch.distance < std::max(reach, 0.0);
    if (!(rings ? anew : anew || detector.touching) || touch.distance >= nearest) continue;
    nearest = touch.distance;
    chosen = number;
  }
  return chosen;
}

void StringPlayers::hand_over(std::int32_t string, std::int32_t player,
                              const StringProximity& near) noexcept {
  const auto s = static_cast<std::size_t>(string);
  PlayedString& track = memory_.tracks[s];
  book_held_force(near.touch.way.value_or(0.0), track.state);
  ToolStringState& before = visit(static_cast<std::size_t>(track.player), string);
  ToolStringState& after = visit(static_cast<std::size_t>(player), string);
  const ReleaseDetector last = track.state.detector;
  if (after.detector.touching) track.place = after.detector.lambda;
  before.detector = last;
  track.state.detector = after.detector;
  // When the string sounded last is known of the string.
  track.state.detector.sounded = last.sounded;
  track.state.detector.sounded_ns = last.sounded_ns;
  after.detector = ReleaseDetector{};
  track.player = player;
}

void StringPlayers::respond_string(std::int32_t string, Tick& tick) noexcept {
  if (is_wave(memory_, string)) {
    play_wave({memory_, sharing_, string}, tick, events_);
    return;
  }
  // Options may change while it rings.
  if (!memory_.waves.empty() && memory_.waves[static_cast<std::size_t>(string)].state.awake) {
    silence_wave({memory_, sharing_, string}, events_);
  }
  PlayedString& track = memory_.tracks[static_cast<std::size_t>(string)];
  if (memory_.tools.size() == 1) {
    play_string(string, proximity_to(memory_.tools[0], visit(0, string), string), tick);
    return;
  }
  std::array<StringProximity, kMaxTools> near;
  for (std::size_t tool = 0; tool < memory_.tools.size(); ++tool) {
    near[tool] = proximity_to(memory_.tools[tool], visit(tool, string), string);
  }
  const std::span<const StringProximity> all(near.data(), memory_.tools.size());
  const std::int32_t player = choose_player(string, all);
  if (player != track.player) {
    hand_over(string, player, near[static_cast<std::size_t>(track.player)]);
  }
  play_string(string, near[static_cast<std::size_t>(track.player)], tick);
  watch_others(string, all);
}

// A string that swings further than the pairs of the contact problem reach, or that the tool has
// come to since they were found, has to be seen all the same.
void StringPlayers::find_ringing(ToolPlay& play) noexcept {
  double swing = 0.0;
  for (const std::int32_t string : awake_) {
    const auto s = static_cast<std::size_t>(string);
    if (is_wave(memory_, string)) {
      swing = std::max(swing, wave_swing(memory_, string));
      continue;
    }
    const StringState& state = memory_.tracks[s].state;
    swing = std::max(
        swing, envelope(play.scene.strings[s], state, state.vibration.lambda, play.way.time.t_ns));
  }
  play.reached_out = false;
  if (swing > 0.0) reach_out(swing, play);
}

void StringPlayers::merge_touched(const PressedStrings& touched) noexcept {
  for (const PressedString& contact : touched) {
    const auto* const at = std::lower_bound(awake_.begin(), awake_.end(), contact.string);
    if (at != awake_.end() && *at == contact.string) continue;
    const auto index = static_cast<std::size_t>(at - awake_.begin());
    if (!awake_.push_back(contact.string)) return;
    std::rotate(awake_.begin() + index, awake_.end() - 1, awake_.end());
  }
}

bool StringPlayers::is_awake(std::int32_t string) const noexcept {
  if (is_wave(memory_, string)) return memory_.waves[static_cast<std::size_t>(string)].state.awake;
  if (awake(memory_.tracks[static_cast<std::size_t>(string)].state)) return true;
  for (std::size_t tool = 0; memory_.tools.size() > 1 && tool < memory_.tools.size(); ++tool) {
    if (visit(tool, string).detector.touching) return true;
  }
  return false;
}

void StringPlayers::end_string(std::int32_t string) noexcept {
  for (std::size_t tool = 0; tool < memory_.tools.size(); ++tool) {
    ToolStringState& seen = visit(tool, string);
    seen.distance = kNotNear;
    seen.u_W = Vector3::Zero();
    seen.v_W = Vector3::Zero();
  }
}

void StringPlayers::play(Tick& tick) noexcept {
  events_.clear();
  tick.strings.clear();
  tick.string_forces.clear();
  tick.string_energy = 0.0;
  for (ToolPlay& play : memory_.tools) find_ringing(play);
  for (std::size_t tool = 0; tool < memory_.tools.size(); ++tool) {
    const PressedStrings& pressed = memory_.tools[tool].rendered.strings;
    merge_touched(pressed);
    for (const PressedString& contact : pressed) {
      tick.string_forces.push_back(
          {static_cast<std::int32_t>(tool), contact.string, to_array(contact.F_W)});
    }
  }
  for (ToolPlay& play : memory_.tools) {
    if (awake_.empty()) break;
    play.way.hand = motion_between(play.way.X_WH_before, play.rendered.X_WH);
  }
  std::size_t kept = 0;
  for (std::size_t k = 0; k < awake_.size(); ++k) {
    const std::int32_t string = awake_[k];
    respond_string(string, tick);
    if (is_awake(string)) {
      awake_[kept++] = string;
    } else {
      end_string(string);
    }
  }
  awake_.truncate(kept);
  tick.tank_energy = tank_energy();
}

double StringPlayers::tank_energy(std::size_t tool) const noexcept {
  double energy = 0.0;
  for (const std::int32_t string : awake_) {
    const auto s = static_cast<std::size_t>(string);
    if (!memory_.waves.empty() && memory_.waves[s].state.awake &&
        memory_.waves[s].state.player == static_cast<std::int32_t>(tool)) {
      energy += std::max(0.0, memory_.waves[s].state.tank.energy);
    }
    const PlayedString& track = memory_.tracks[s];
    if (track.player == static_cast<std::int32_t>(tool)) energy += track.state.tank.energy;
  }
  return energy;
}

double StringPlayers::tank_energy() const noexcept {
  double energy = 0.0;
  for (std::size_t tool = 0; tool < memory_.tools.size(); ++tool) energy += tank_energy(tool);
  return energy;
}

bool StringPlayers::set_awake(std::span<const std::int32_t> strings) noexcept {
  std::int32_t before = -1;
  for (const std::int32_t string : strings) {
    if (string <= before || static_cast<std::size_t>(string) >= memory_.tracks.size()) return false;
    before = string;
  }
  awake_.clear();
  for (const std::int32_t string : strings) awake_.push_back(string);
  return true;
}

}  // namespace hapticd
