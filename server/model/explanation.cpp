// See explanation.h. Numbers that are not of the scene at hand are closed forms, or stand in
// string_costs.inc and tests/benchmark/results.
#include "server/model/explanation.h"

#include <algorithm>
#include <iomanip>
#include <set>
#include <sstream>
#include <vector>

#include "core/scene/quality.h"
#include "core/scene/sagging_cable.h"
#include "server/model/scene_features.h"
#include "server/model/string_cost.h"
#include "server/model/surface_ripple.h"
#include "server/scene_io/scene_defaults.h"

namespace hapticd {
namespace {

std::string in_um(double metres) {
  std::ostringstream text;
  text << std::setprecision(3) << 1e6 * metres << " um";
  return text.str();
}

std::string spheres(std::size_t count) {
  return std::to_string(count) + (count == 1 ? " sphere" : " spheres");
}

void print_shape(std::ostream& out, const std::string& name, const ShapeDescription& shape,
                 int level) {
  const MeasuredTree& file = *shape.tree;
  out << "  " << name << ": ";
  if (shape.exact) {
    out << spheres(file.tree.leaf_r.size()) << " as written, exact\n";
    return;
  }
  const PlayedShape played = played_shape(shape, level);
  out << (played.level > 0
              ? std::to_string(played.spheres) + " spheres of level " + std::to_string(played.level)
              : spheres(played.spheres))
      << " of " << shape.tree_name << ", at most " << in_um(played.outer);
  out << " outside its mesh";
  const double blend = file.tree.blend.width;
  if (blend > 0.0 && level == 0) {
    out << ", blended over " << std::setprecision(3) << 1e3 * blend << " mm into one surface";
  }
  if (file.inner > 0.0) out << ", which may stick out of them by " << in_um(file.inner);
  out << "\n";
}

void print_ripple(std::ostream& out, const ShapeDescription& shape) {
  const SurfaceRipple ripple = measure_ripple(shape.tree->tree);
  if (ripple.patches == 0) return;
  out << "    ripple under a tip of " << 1e3 * kRippleTip << " mm: " << in_um(ripple.height)
      << " and " << std::setprecision(2) << kRadianInDegrees * ripple.angle << " degrees rms\n";
}

/// Of axes that differ.
void print_axes(std::ostream& out, const CouplingStiffness& stiffness) {
  if (!stiffness.per_axis) return;
  const auto axes = [&out](const Vector3& k) -> std::ostream& {
    return out << k.x() << ", " << k.y() << ", " << k.z();
  };
  out << "  coupling: ";
  axes(stiffness.along_W()) << " N/m along x, y, z of the world; ";
  axes(stiffness.about_G()) << " N m/rad about x, y, z of the tool\n";
}

/// Once, where it is the same of all strings.
void print_tuning(std::ostream& out, const std::vector<StringDescription>& strings) {
  std::set<std::string> kinds;
  for (const StringDescription& string : strings) kinds.insert(string_tuning(string.parameters));
  if (kinds.size() == 1) {
    out << "  tuning: " << *kinds.begin() << "\n";
    return;
  }
  for (const StringDescription& string : strings) {
    out << "  tuning of " << string.name << ": " << string_tuning(string.parameters) << "\n";
  }
}

void print_objects(std::ostream& out, const Scene& scene) {
  const SceneDescription& d = scene.description();
  for (std::size_t i = 0; i < d.tools.size(); ++i) {
    out << "tool " << d.tools[i].tool_id << ", " << d.tools[i].name << ": "
        << spheres(scene.tool_spheres(i)) << "\n";
    print_axes(out, d.tools[i].coupling);
    for (const PartDescription& part : d.tools[i].parts) {
      const bool soft = part.softness.stiffness > 0.0;
      print_shape(out, part.name + (soft ? " (soft)" : ""), part.shape,
                  shown_level(d.contact.tool_level));
    }
  }
  if (!d.bodies.empty()) out << "bodies: " << spheres(scene.body_spheres()) << "\n";
  for (const BodyDescription& body : d.bodies) {
    print_shape(out, body.name, body.shape, shown_level(d.contact.body_level));
    if (d.contact.body_level == kLeafLevel) print_ripple(out, body.shape);
  }
  const std::size_t capsules = scene.capsule_owners().size() - scene.string_pieces();
  if (!d.lines.empty()) {
    out << "rigid lines: " << d.lines.size() << " of " << capsules << " capsules, exact\n";
  }
  if (!d.strings.empty()) {
    out << "strings: " << d.strings.size();
    if (scene.string_pieces() != d.strings.size()) {
      out << " of " << scene.string_pieces() << " pieces";
    }
    out << "\n";
    print_tuning(out, d.strings);
  }
  for (const StringDescription& string : d.strings) {
    if (string.sag == 0.0) continue;
    out << "  " << string.name << ": " << cable_pieces(string.sag) << " straight pieces, at most "
        << in_um(cable_error(string.sag))
        << " off the parabola; each yields between its own ends\n";
  }
}

void print_features(std::ostream& out, const SceneDescription& d) {
  out << "modelled\n";
  for (const std::string& feature : modelled(d)) out << "  " << feature << "\n";
  out << "not modelled, at no cost\n";
  for (const std::string& feature : not_modelled(d)) out << "  " << feature << "\n";
}

void print_accuracy(std::ostream& out, const LoadedScene& loaded) {
  const ContactOptions& o = loaded.scene->description().contact;
  const v1::Quality& quality = loaded.message.quality();
  out << "accuracy beside the shapes\n  forces are those of the exact surfaces, of which a tool in "
         "fast motion keeps clear by "
      << in_um(o.skin) << ", the skin;\n    nothing is ever entered\n";
  const int level = quality_level(quality);
  const Quality measured = quality_of(level);
  if (is_as_measured(o, measured)) {
    out << "  quality " << level << ": force error at most " << 100.0 * measured.force_error
        << " % rms in the gestures of hapticd-lab tradeoff, at up to " << o.sub_steps
        << " linearisations a tick;\n    predicted work of a tick in touch: " << measured.work
        << " times that of quality " << kDefaultQuality << ", the default\n";
  } else {
    out << "  up to " << o.sub_steps << " linearisations a tick, steps below "
        << in_um(o.stop_tolerance) << " end it\n";
  }
}

void print_times(std::ostream& out, const char* what, const TickTimes& times) {
  out << "  " << what << ": ";
  if (times.ticks == 0) {
    out << "never on this path\n";
    return;
  }
  out << std::setprecision(2) << std::fixed << times.median << " us, 99 % below " << times.p99
      << " us, worst " << times.worst << " us of " << times.ticks << " ticks\n"
      << std::defaultfloat;
}

void print_bound(std::ostream& out, const BoundedTicks& bounded, bool automatic) {
  out << "work of a tick: bounded to " << std::setprecision(6) << bounded.budget_us
      << " us of processor time, "
      << (automatic ? "the budget of automatic quality\n"
                    : "half of a tick at 1 kHz;\n    bounded otherwise with 'hapticd --budget-us "
                      "N', not at "
                      "all where N is 0\n")
      << std::setprecision(2) << std::fixed << "  the most on this path: " << bounded.most_us
      << " us here; " << std::defaultfloat;
  if (bounded.beyond == 0) {
    out << "no tick of " << bounded.ticks << " would be cut short\n";
    return;
  }
  out << bounded.beyond << " of " << bounded.ticks
      << " ticks would be cut short: the tool lags, and enters nothing\n";
}

}  // namespace

std::string explain(const LoadedScene& loaded, const TickCost& cost) {
  const SceneDescription& d = loaded.scene->description();
  std::ostringstream out;
  out << "scene " << d.name;
  if (!loaded.message.description().empty()) out << ": " << loaded.message.description();
  out << "\n";
  print_objects(out, *loaded.scene);
  print_features(out, d);
  print_accuracy(out, loaded);
  out << "cost of a tick on this machine, the first tool led into every object\n";
  print_times(out, "free", cost.free);
  print_times(out, "in contact", cost.contact);
  print_bound(out, cost.bounded, loaded.message.quality().has_automatic());
  out << string_costs(d);
  out << "memory: " << (loaded.scene->memory() + 1023) / 1024 << " KiB\n";
  return out.str();
}

}  // namespace hapticd
