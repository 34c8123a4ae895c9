// See settings_change.h. RT: yes.
#include "server/haptic_loop/settings_change.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/contact/coupling_axes.h"
#include "core/math/elementary.h"
#include "server/haptic_loop/device_limits.h"

namespace hapticd {
namespace {

/// What the device would feel of the settings, unclamped.
DeviceStiffness wanted_stiffness(const LiveSettings& live,
                                 const std::vector<StringParameters>& pieces) noexcept {
  const double to_device = live.scale * live.force_gain;
  DeviceStiffness wanted;
  wanted.kt = live.coupling.kt * to_device;
  wanted.kr = stiffest_rotation(live.coupling) * live.force_gain;
  for (const StringParameters& piece : pieces) {
    wanted.kc = std::max(wanted.kc, std::min(piece.contact_stiffness, live.coupling.kt));
  }
  wanted.kc *= to_device;
  return wanted;
}

/// What the device of `played` bears of the settings.
StiffnessGrant grant_of(const LiveSettings& live, const std::vector<StringParameters>& pieces,
                        const PlayedTool& played) noexcept {
  StiffnessLimits limits = played.stiffness_limits;
  limits.coupling_damping = live.coupling_damping;
  StiffnessGrant grant = grant_stiffness(wanted_stiffness(live, pieces), limits);
  // Where poses come from data force moves nothing, and no stiffness is too high; unless the client
  // that sends them has a device.
  const DriverTraits& driver = played.device.traits;
  if (driver.follows_data && !reaches_a_hand(played.device.device->profile(), driver)) {
    grant.scale = 1.0;
  }
  return grant;
}

/// Puts `live` in force for one tool, all but the strings.
void apply_to_tool(const LiveSettings& live, const std::vector<StringParameters>& pieces,
                   PlayedTool& played, ToolScene& tool) noexcept {
  played.grant = grant_of(live, pieces, played);
  played.grant.scale = std::min(played.grant.scale, played.most_scale);
  tool.stiffness = live.coupling;
  tool.stiffness.kt *= played.grant.scale;
  tool.coupling_damping = live.coupling_damping;
  tool.options = live.contact;
  tool.instrument = live.instrument;
  played.map.scale = live.scale;
  played.map.X_WD = live.X_WD;
  played.force_gain = live.force_gain;
}

/// A tool whose coupling gives more is in touch, N. Smaller: rounding holds a map up; larger: a
/// light touch is pulled at as if there were none.
constexpr double kTouchingForce = 1e-6;
/// What a tick may change of a tool's force: this, N, or a share of what changes in all. Above 5 mN
/// and 3/50 it is felt as a step; smaller takes longer.
constexpr double kLeastStep = 3.5e-3;
constexpr double kSharePerStep = 0.05;

/// A straight string's force follows a coupling, which it is not in series with, in this power, at
/// most.
constexpr double kStraightPower = 1.5;

/// How far the coupling of `tool` is stretched, m; turning counts at its `length`.
double stretch_of(const PulledTool& tool, double length) noexcept {
  const Vector3 turned = 2.0 * length * (tool.X_WH.q * tool.X_WG.q.conjugate()).vec();
  return std::sqrt((tool.X_WH.p - tool.X_WG.p).squaredNorm() + turned.squaredNorm());
}

/// True where strings of `settings` hold what slides on them: stuck they give another force than
/// slipping, and where one goes over into the other is an edge of every scale and of the map.
bool rubs(const SceneSettings& settings) noexcept {
  return settings.tools.front().instrument.friction &&
         std::any_of(
             settings.pieces.begin(), settings.pieces.end(),
             [](const StringParameters& piece) { return piece.friction_coefficient > 0.0; });
}

/// How far a tick may go at `share` of a way of length `edged`, as a logarithm: what lies behind or
/// ahead may all be beyond an edge, and then exp of it is all that force changes by.
double edge_room(double edged, double share) noexcept {
  return kSharePerStep * (1.0 - exponential(-edged * std::min(share, 1.0 - share)));
}

/// Above it no contact stiffness of a string has an effect anywhere along `change`, N/m. Among
/// several tools there is none: each coupling is as stiff as its own device bears, a string as the
/// weakest does.
double stiffest_of(const SettingsChange& change) noexcept {
  if (change.to.tools.size() > 1) return std::numeric_limits<double>::infinity();
  return std::max(change.from.tools.front().coupling.kt, change.to.tools.front().coupling.kt);
}

/// How fast the map of `live` may move a hand at p_DH along a change, m per share; turning counts
/// at the coupling's length.
double pull_rate(const LiveSettings& from, const LiveSettings& to, const LiveSettings& live,
                 const Array3& p_DH) noexcept {
  const double way = (to.X_WD.p - from.X_WD.p).norm();
  // A normalised straight line between quaternions is fastest half way.
  const double cosine = std::min(1.0, std::abs(from.X_WD.q.dot(to.X_WD.q)));
  const double turn = 4.0 * std::sqrt((1.0 - cosine) / (1.0 + cosine));
  const double stretch = std::abs(logarithm(to.scale / from.scale));
  const double reach = live.scale * to_vector(p_DH).norm();
  return way + reach * (turn + stretch) + live.coupling.length * turn;
}

}  // namespace

void apply_settings(PlayedScene& scene) noexcept {
  // Strings are shared: they are as stiff as the weakest device bears.
  double scale = 1.0;
  for (std::size_t k = 0; k < scene.tools.size(); ++k) {
    apply_to_tool(scene.settings.tools[k], scene.settings.pieces, scene.tools[k],
                  scene.play.simulation->scene(k));
    scale = std::min(scale, scene.tools[k].grant.scale);
  }
  scene.quality_level = scene.settings.tools.front().quality_level;
  for (std::size_t k = 0; k < scene.strings.size(); ++k) {
    scene.strings[k] = derive_string(scene.settings.pieces[k]);
    scene.strings[k].contact_stiffness *= scale;
  }
}

// A scale that a ramp has held below what the device bears is the setting's own from here on.
void begin_change(const PlayedScene& scene, SettingsChange& change) noexcept {
  HD_ASSERT(change.from.pieces.size() == scene.settings.pieces.size());
  HD_ASSERT(change.from.tools.size() == scene.settings.tools.size());
  std::copy(scene.settings.tools.begin(), scene.settings.tools.end(), change.from.tools.begin());
  std::copy(scene.settings.pieces.begin(), scene.settings.pieces.end(), change.from.pieces.begin());
  double in_force = 1.0;
  double borne = 1.0;
  for (std::size_t k = 0; k < scene.tools.size(); ++k) {
    const PlayedTool& played = scene.tools[k];
    LiveSettings& from = change.from.tools[k];
    if (played.grant.scale < grant_of(from, scene.settings.pieces, played).scale) {
      from.coupling.kt *= played.grant.scale;
    }
    in_force = std::min(in_force, played.grant.scale);
    borne = std::min(borne, grant_of(from, scene.settings.pieces, played).scale);
  }
  if (in_force < borne) {
    for (StringParameters& piece : change.from.pieces) piece.contact_stiffness *= in_force / borne;
  }
  measure(change);
}

void measure(SettingsChange& change) noexcept {
  WayLength length;
  const auto add = [&](const WayLength& each) {
    length = {std::max(length.most, each.most), std::max(length.edged, each.edged)};
  };
  const double stiffest = stiffest_of(change);
  change.straight = false;
  change.rubs = rubs(change.from) || rubs(change.to);
  for (std::size_t k = 0; k < change.to.pieces.size(); ++k) {
    add(way_length(change.from.pieces[k], change.to.pieces[k], stiffest));
    if (change.to.pieces[k].model == StringContact::kStraight) change.straight = true;
  }
  for (std::size_t k = 0; k < change.to.tools.size(); ++k) {
    const WayLength tool = way_length(change.from.tools[k], change.to.tools[k]);
    const double straight = kStraightPower * tool.most;
    add(change.straight ? WayLength{straight, straight} : tool);
  }
  change.time_s = ramp_time(length);
  change.edged = change.rubs ? length.most : length.edged;
}

double next_share(const SettingsChange& change, double share, double dt_s, const PlayedScene& scene,
                  std::span<const PulledTool> tools) noexcept {
  double step = dt_s / change.time_s;
  for (std::size_t k = 0; k < scene.tools.size(); ++k) {
    const LiveSettings& now = scene.settings.tools[k];
    const double kt = now.coupling.kt * scene.tools[k].grant.scale;
    const double stretched = stretch_of(tools[k], now.coupling.length);
    if (!(kt * stretched > kTouchingForce)) continue;
    const double least = kLeastStep / (kt * stretched);
    const double edge = std::max(least, edge_room(change.edged, share));
    step = std::min(step, edge / std::max(change.edged, edge));
    const double rate = pull_rate(change.from.tools[k], change.to.tools[k], now, tools[k].p_DH);
    double room = stretched * (change.straight ? least : std::max(least, kSharePerStep));
    if (change.rubs) {
      const double nearest = rate * std::min(share, 1.0 - share);
      room = std::min(room, std::max(stretched * least, kSharePerStep * nearest));
    }
    step = std::min(step, room / std::max(rate, room));
  }
  return std::min(share + step, 1.0);
}

void follow_change(const SettingsChange& change, double share, PlayedScene& scene) noexcept {
  HD_ASSERT(change.to.pieces.size() == scene.settings.pieces.size());
  for (std::size_t k = 0; k < scene.settings.tools.size(); ++k) {
    scene.settings.tools[k] = blend(change.from.tools[k], change.to.tools[k], share);
  }
  StringBlend blend_string(share, stiffest_of(change));
  for (std::size_t k = 0; k < scene.settings.pieces.size(); ++k) {
    scene.settings.pieces[k] = blend_string(change.from.pieces[k], change.to.pieces[k]);
  }
  for (std::size_t k = 0; k < scene.tools.size(); ++k) {
    PlayedTool& played = scene.tools[k];
    const double from = grant_of(change.from.tools[k], change.from.pieces, played).scale;
    const double to = grant_of(change.to.tools[k], change.to.pieces, played).scale;
    played.most_scale = share >= 1.0 ? 1.0 : blend_scale(from, to, share);
  }
  apply_settings(scene);
}

bool usable(const SceneSettings& settings) noexcept {
  const auto positive = [](double x) { return std::isfinite(x) && x > 0.0; };
  const auto fine = [&](const LiveSettings& live) {
    return positive(live.coupling.kt) && positive(live.coupling.length) &&
           usable(live.coupling.shares) && positive(live.scale) && usable(live.contact) &&
           std::isfinite(live.force_gain) && std::isfinite(live.coupling_damping) &&
           live.X_WD.p.allFinite() && std::abs(live.X_WD.q.norm() - 1.0) < 1e-6 &&
           !check_options(live.instrument);
  };
  return std::all_of(settings.tools.begin(), settings.tools.end(), fine) &&
         std::none_of(
             settings.pieces.begin(), settings.pieces.end(),
             [](const StringParameters& piece) { return check_string(piece).has_value(); });
}

}  // namespace hapticd
