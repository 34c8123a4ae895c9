// Where contacts are led, how stiff they are, and the steps of a tick. See wave_string.h. RT: yes.
#include "core/instrument/wave_string.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

/// Stiffness of a finger's flesh, N/m. Softer: a stop sounds flat; stiffer: noise of the hand is
/// felt through the string.
constexpr double kFlesh = 2e4;
/// Its damping, N s/m.
constexpr double kFleshDamping = 1.0;
/// A tool is firm after so long in touch, s, with a hand slower than kStill, m/s, until one faster
/// than kMoves.
constexpr double kFirmAfter = 0.08;
constexpr double kStill = 0.05;
constexpr double kMoves = 0.1;
/// Of the means of speed and load, s.
constexpr double kSpeedTime = 0.01;
constexpr double kLoadTime = 0.005;
/// Time that is stepped at once, ns; longer pauses begin their contacts anew.
constexpr std::int64_t kMaxStepped_ns = 5'000'000;
/// The string is put where the static law has it after so long without a force where that presses,
/// s: the two disagree on which side of the tool it is.
constexpr double kAstrayAfter = 0.1;
/// A compliance counts as this at least, m/N.
constexpr double kMinCompliance = 1e-9;

double length(const Transverse& a) noexcept { return std::sqrt(a.y * a.y + a.z * a.z); }
Transverse minus(const Transverse& a, const Transverse& b) noexcept {
  return {a.y - b.y, a.z - b.z};
}
Transverse along(const Transverse& a, double factor, const Transverse& b) noexcept {
  return {a.y + factor * b.y, a.z + factor * b.z};
}

double seconds(std::int64_t ns) noexcept { return 1e-9 * static_cast<double>(ns); }

/// All that one tick of a string works on.
struct Stepping {
  const WaveModel& model;
  WaveString& state;
  double dt;     ///< of the sub-steps, s
  double share;  ///< of the way to the end of the tick that they go
};

/// Firm or soft from here on. Returns true where that changed.
bool settle_grip(const WaveTouch& touch, double dt, WaveContact& contact) noexcept {
  const bool before = contact.firm;
  contact.speed += (touch.hand_speed - contact.speed) * std::min(1.0, dt / kSpeedTime);
  if (!(touch.force > 0.0)) {
    contact.held = 0.0;
    contact.firm = false;
  } else {
    contact.held += dt;
    if (contact.held >= kFirmAfter && contact.speed < kStill) contact.firm = true;
    if (contact.speed > kMoves) contact.firm = false;
  }
  return contact.firm != before;
}

/// Compliance of the contact, without what the modes leave out, m/N.
double contact_compliance(const WaveTouch& touch, bool firm) noexcept {
  const double soft = std::max(touch.compliance, kMinCompliance);
  return firm ? std::min(soft, touch.part_compliance + 1.0 / kFlesh) : soft;
}

/// Of that what is not of soft parts, which stand where they stand, m/N.
double coupling_compliance(const WaveTouch& touch, bool firm) noexcept {
  return std::max(0.0, contact_compliance(touch, firm) - touch.part_compliance);
}

/// Where a contact is led, and how large it is there.
struct Lead {
  Transverse d;
  double radius;
};

/// Where there is friction, the string turns about the sphere where it stands, as by the static
/// law: its centre stays and its radius grows by what the contact yields to the static force.
/// Without, the centre goes into the string by that, as the hand does; but where it is more than
/// half of the radius it stays behind, and grows as much: it never comes to the string's axis.
Lead lead(const WaveTouch& touch, bool firm, bool sticks) noexcept {
  const double yielded = touch.force * coupling_compliance(touch, firm);
  const double aside = touch.part_aside.y * touch.normal.y + touch.part_aside.z * touch.normal.z;
  const double beyond = std::max(0.0, yielded + aside - 0.5 * touch.radius);
  const double more = sticks ? yielded : beyond;
  const Transverse centre = minus(touch.centre, touch.part_aside);
  return {along(centre, more - yielded, touch.normal), touch.radius + more};
}

/// Displacement of the string at lambda, m.
Transverse displacement_at(const Stepping& tick, double lambda) noexcept {
  PerMode shapes{};
  mode_shapes(tick.model.table.modes, lambda, shapes);
  return displacement(tick.model.table.modes, tick.state.motion, shapes);
}

/// Bent by `force` (N, on it) at lambda as at rest; of what it did before nothing is left.
void lay(const Stepping& tick, double lambda, const Transverse& force) noexcept {
  const ModeTable& modes = tick.model.table.modes;
  PerMode shapes{};
  mode_shapes(modes, lambda, shapes);
  ModalMotion& motion = tick.state.motion;
  motion = ModalMotion{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(modes.count); ++i) {
    motion.qy[i] = shapes[i] * force.y / modes.stiffness[i];
    motion.qz[i] = shapes[i] * force.z / modes.stiffness[i];
  }
}

/// Friction holds the string on tools.
bool sticks(const Stepping& tick) noexcept {
  return tick.model.options.friction && tick.model.string.friction_coefficient > 0.0;
}

/// Nothing else touches the string.
bool is_alone(const WaveString& state, const WaveContact& contact) noexcept {
  return std::all_of(state.contacts.begin(), state.contacts.end(),
                     [&](const WaveContact& other) { return &other == &contact || !other.near; });
}

void begin(const Stepping& tick, const WaveTouch& touch, WaveContact& contact) noexcept {
  const Lead to = lead(touch, contact.firm, sticks(tick));
  contact.speed = touch.hand_speed;
  contact.path.slope = 0.0;
  contact.path.stretched = 0.0;
  contact.path.stored = 0.0;
  contact.path.lambda_to = touch.lambda_before;
  contact.path.d_to = minus(touch.centre_before, touch.part_aside);
  contact.lacking = 0.0;
  const Transverse u = displacement_at(tick, touch.lambda_before);
  const double r = length(minus(contact.path.d_to, u));
  const bool asleep = energy(tick.model.table.modes, tick.state.motion) == 0.0;
  if (r < touch.radius && touch.force > 0.0 && asleep) {
    // Pressed before the string was watched.
    lay(tick, touch.lambda, {-touch.law.y, -touch.law.z});
    contact.path.lambda_to = touch.lambda;
    contact.path.d_to = to.d;
    contact.path.radius = to.radius;
    return;
  }
  contact.path.radius = std::min(touch.radius, r);
  contact.lacking = touch.radius - contact.path.radius;
}

/// A path that the string could be passed by in one sub-step is not swept.
void sweep_or_jump(const Stepping& tick, const Lead& to, int steps, WaveContact& contact) noexcept {
  StringContactPath& path = contact.path;
  path.d_from = path.d_to;
  path.lambda_from = path.lambda_to;
  path.radius_from = path.radius;
  const double way = length(minus(to.d, path.d_from));
  if (way <= 0.5 * to.radius * steps) return;
  path.d_from = to.d;
  path.radius_from = 0.0;
  const double r = length(minus(to.d, displacement_at(tick, path.lambda_from)));
  contact.lacking = std::max(0.0, to.radius - r);
}

/// Leads a contact through the tick.
void prepare(const Stepping& tick, const WaveTouch& touch, int steps,
             WaveContact& contact) noexcept {
  StringContactPath& path = contact.path;
  if (!contact.near) begin(tick, touch, contact);
  contact.near = true;
  if (settle_grip(touch, tick.dt, contact)) {
    // From where the other grip would have been; what is stored differently is the model's.
    const double compliance = coupling_compliance(touch, contact.firm);
    path.d_to = contact.centre;
    path.radius = contact.reach - contact.lacking;
    if (sticks(tick)) {
      path.radius += compliance * length(contact.push);
    } else {
      path.d_to = along(contact.centre, -compliance, contact.push);
    }
  }
  const Lead to = lead(touch, contact.firm, sticks(tick));
  sweep_or_jump(tick, to, steps, contact);
  path.d_to = along(path.d_from, tick.share, minus(to.d, path.d_from));
  path.lambda_to = path.lambda_from + tick.share * (touch.lambda - path.lambda_from);
  const double grown = length(minus(path.d_from, displacement_at(tick, path.lambda_from)));
  contact.lacking = std::clamp(to.radius - grown, 0.0, contact.lacking);
  contact.centre = minus(touch.centre, touch.part_aside);
  contact.reach = touch.radius;
  contact.push = {touch.force * touch.normal.y, touch.force * touch.normal.z};
  path.shape = StringContactShape::kRound;
  const double radius = to.radius - contact.lacking;
  path.radius =
      path.radius_from > 0.0 ? path.radius_from + tick.share * (radius - path.radius_from) : radius;
  path.stiffness = 1.0 / contact_compliance(touch, contact.firm);
  const double flesh = contact.firm ? kFleshDamping : 0.0;
  path.damping = touch.part_compliance > 0.0 ? touch.part_damping : flesh;
  path.friction = tick.model.options.friction ? tick.model.string.friction_coefficient : 0.0;
  path.bristle = tick.model.options.anchor_stiffness;
}

/// A tool that is no longer near.
void let_go(WaveContact& contact) noexcept { contact = WaveContact{}; }

void follow(const Stepping& tick, const WaveTouch& touch, WaveContact& contact) noexcept {
  const double share = std::min(1.0, tick.dt / kLoadTime);
  contact.load = along(contact.load, share, minus(contact.path.force, contact.load));
  const bool misses = touch.force > 0.0 && contact.path.touched == 0;
  contact.astray = misses ? contact.astray + tick.dt : 0.0;
  if (contact.astray < kAstrayAfter || !is_alone(tick.state, contact)) return;
  lay(tick, touch.lambda, {-touch.law.y, -touch.law.z});
  const Lead to = lead(touch, contact.firm, sticks(tick));
  contact.path.d_to = to.d;
  contact.path.radius = to.radius;
  contact.path.lambda_to = touch.lambda;
  contact.lacking = 0.0;
  contact.astray = 0.0;
}

}  // namespace

WaveTuning tuning_at(const StringConstants& string, double tension,
                     const InstrumentOptions& options) noexcept {
  WaveTuning tuning;
  tuning.length = string.length;
  tuning.tension = tension;
  tuning.modal_mass = string.modal_mass;
  tuning.decay = string.decay;
  tuning.loss_n2 = string.loss_n2;
  tuning.modes = options.modes;
  tuning.substeps = options.substeps;
  if (!(string.frequency > 0.0)) return tuning;
  const double raised = tension / string.tension;
  tuning.frequency = string.frequency * std::sqrt(raised);
  tuning.inharmonicity = string.inharmonicity / raised;
  return tuning;
}

void rest(std::int64_t t_ns, WaveString& string) noexcept {
  string.motion = ModalMotion{};
  string.done_ns = t_ns;
  for (WaveContact& contact : string.contacts) contact = WaveContact{};
  string.rests = WaveRests{};
}

void retune(const WaveTuning& tuning, WaveTable& table, WaveString& string) noexcept {
  const auto constants = [](const WaveTuning& of) {
    StringConstants made;
    made.length = of.length;
    made.tension = of.tension;
    made.frequency = of.frequency;
    made.modal_mass = of.modal_mass;
    made.inharmonicity = of.inharmonicity;
    return made;
  };
  const auto make = [&](const WaveTuning& of) {
    table.of = of;
    table.modes = mode_table(constants(of), {of.decay, of.loss_n2}, of.modes, of.substeps);
  };
  if (table.of != string.tuning) make(string.tuning);
  if (tuning == string.tuning) return;
  const PerMode before = table.modes.omega;
  const int count = table.modes.count;
  make(tuning);
  string.tuning = tuning;
  string.count = table.modes.count;
  for (std::size_t i = 0; i < static_cast<std::size_t>(kMaxModes); ++i) {
    const bool stays = i < static_cast<std::size_t>(std::min(count, table.modes.count));
    const double speed = stays ? before[i] / table.modes.omega[i] : 0.0;
    string.motion.vy[i] *= speed;
    string.motion.vz[i] *= speed;
    if (stays) continue;
    string.motion.qy[i] = 0.0;
    string.motion.qz[i] = 0.0;
  }
}

void turn_to(std::int64_t t_ns, const WaveTable& table, WaveString& string) noexcept {
  const std::int64_t steps = (t_ns - string.done_ns) / step_ns(string.tuning);
  if (steps <= 0) return;
  turn_on(table.modes, steps, string.motion);
  string.done_ns += steps * step_ns(string.tuning);
}

WaveTick step(const WaveModel& model, const TickTime& time,
              std::span<const WaveTouch* const> touches, WaveString& state) noexcept {
  if (time.t_ns - state.done_ns > kMaxStepped_ns) {
    for (WaveContact& contact : state.contacts) let_go(contact);
    state.rests = WaveRests{};
    turn_to(time.t_ns - kMaxStepped_ns, model.table, state);
  }
  WaveTick tick;
  tick.from_ns = state.done_ns;
  tick.step_ns = step_ns(state.tuning);
  tick.steps =
      static_cast<int>(std::max<std::int64_t>(0, (time.t_ns - state.done_ns) / tick.step_ns));
  if (tick.steps == 0) return tick;
  const std::int64_t length_ns = tick.steps * tick.step_ns;
  const Stepping stepping{model, state, seconds(length_ns),
                          seconds(length_ns) / seconds(time.t_ns - state.done_ns)};
  StringContactPaths paths;
  for (std::size_t tool = 0; tool < state.contacts.size(); ++tool) {
    const bool near = tool < touches.size() && touches[tool] != nullptr;
    WaveContact& contact = state.contacts[tool];
    if (!near) {
      let_go(contact);
      continue;
    }
    prepare(stepping, *touches[tool], tick.steps, contact);
    paths.push_back(contact.path);
  }
  const std::size_t tools = paths.size();
  prepare_rests({model.table.modes, state.motion, model.options.anchor_stiffness,
                 model.options.friction, stepping.dt},
                model.rests, state.rests, paths);
  StringConstants now = model.string;
  now.tension = state.tuning.tension;
  tick.fallbacks = play(now, model.table.modes, tick.steps, paths, state.motion);
  state.done_ns += length_ns;
  std::size_t next = 0;
  for (std::size_t tool = 0; tool < touches.size(); ++tool) {
    if (touches[tool] == nullptr) continue;
    state.contacts[tool].path = paths[next++];
    follow(stepping, *touches[tool], state.contacts[tool]);
  }
  follow_rests(paths, tools, tick.steps, stepping.dt, state.rests);
  return tick;
}

ModalMotion ringing_motion(const WaveTable& table, const WaveString& string) noexcept {
  ModalMotion about = string.motion;
  const auto take_out = [&](const StringContactPath& path, const Transverse& load) {
    if (load.y == 0.0 && load.z == 0.0) return;
    PerMode shapes{};
    mode_shapes(table.modes, path.lambda_to, shapes);
    for (std::size_t i = 0; i < static_cast<std::size_t>(table.modes.count); ++i) {
      about.qy[i] -= shapes[i] * load.y / table.modes.stiffness[i];
      about.qz[i] -= shapes[i] * load.z / table.modes.stiffness[i];
    }
  };
  for (const WaveContact& contact : string.contacts) take_out(contact.path, contact.load);
  for (const WaveRest& held : string.rests) take_out(held.path, held.load);
  return about;
}

double ringing_energy(const WaveTable& table, const WaveString& string) noexcept {
  return energy(table.modes, ringing_motion(table, string));
}

double reach_of(const WaveTuning& tuning, double energy, double lambda) noexcept {
  if (!(tuning.tension > 0.0)) return 0.0;
  // u = phi . q, and q' K q <= 2 E.
  const double compliance = lambda * (1.0 - lambda) * tuning.length / tuning.tension;
  return std::sqrt(2.0 * energy * compliance);
}

}  // namespace hapticd
