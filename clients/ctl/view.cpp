// See view.h.
#include "clients/ctl/view.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <utility>

#include "clients/ctl/text.h"
#include "proto/wire/shown_text.h"

namespace hapticd::ctl {
namespace {

constexpr double kMicro = 1e-3;  ///< us per ns
/// Silence after which a line says so, s.
constexpr double kSilence = 1.0;
constexpr std::size_t kBarWidth = 40;

[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  char buffer[400];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(buffer, sizeof buffer, pattern, arguments);
  va_end(arguments);
  return buffer;
}

/// Element i of a list that may be short.
template <typename List>
double at(const List& list, int i) {
  return i < list.size() ? static_cast<double>(list.Get(i)) : 0.0;
}

template <typename List>
double length(const List& list, int first) {
  return std::hypot(at(list, first), at(list, first + 1), at(list, first + 2));
}

/// The name of the thing with this index; `otherwise` where there is none, for the daemon may say
/// any number.
template <typename List>
std::string name_in(const List& list, std::uint32_t index, const std::string& otherwise) {
  return index < static_cast<std::uint32_t>(list.size()) ? list.Get(static_cast<int>(index)).name()
                                                         : otherwise;
}

std::string string_name(const View& view, std::uint32_t index) {
  return name_in(view.scene.scene().strings(), index, "string " + std::to_string(index));
}

std::string object_name(const View& view, const v1::ContactPatch& contact) {
  const v1::Scene& scene = view.scene.scene();
  if (contact.object_case() == v1::ContactPatch::kStringIndex) {
    return string_name(view, contact.string_index());
  }
  const bool is_line = contact.object_case() == v1::ContactPatch::kLineIndex;
  return is_line ? name_in(scene.lines(), contact.line_index(), "line")
                 : name_in(scene.bodies(), contact.body_index(), "body");
}

std::string tool_name(const View& view, std::uint32_t id) {
  for (const v1::Tool& tool : view.scene.scene().tools()) {
    if (tool.tool_id() == id) return tool.name();
  }
  return "tool " + std::to_string(id);
}

std::string head_line(const View& view) {
  const v1::State& state = view.state;
  std::string text = "hapticd " + view.scene.server_version() + " at " + view.server + ": scene " +
                     view.scene.scene().name();
  text += format(", %g Hz", view.scene.rate_hz());
  if (view.scene.clock() == v1::CLOCK_MODE_VIRTUAL) text += " virtual";
  if (!view.has_state) {
    if (view.scene.next_tick() == 0) return text + ", no tick yet";
    return text + format(", time stands before tick %llu",
                         static_cast<unsigned long long>(view.scene.next_tick()));
  }
  text += ", " + plain_name(v1::LoopState_Name(state.loop_state()), "LOOP_STATE_");
  if (state.cause() != v1::CAUSE_UNSPECIFIED) {
    text += " (" + plain_name(v1::Cause_Name(state.cause()), "CAUSE_") + ")";
  }
  return text;
}

void add_tool(const View& view, const v1::ToolState& tool, std::vector<std::string>& lines) {
  std::string line =
      format("%-10s p %8.2f %8.2f %8.2f mm   force %6.3f N  torque %6.4f N m   gap %7.3f mm",
             wire::whole_characters(tool_name(view, tool.tool_id()), 10).c_str(),
             1e3 * at(tool.p_wh_m(), 0), 1e3 * at(tool.p_wh_m(), 1), 1e3 * at(tool.p_wh_m(), 2),
             length(tool.wrench_h_w(), 0), length(tool.wrench_h_w(), 3),
             1e3 * static_cast<double>(tool.minimum_gap_m()));
  for (const int flag : tool.flags()) {
    line += "  " + plain_name(v1::ToolFlag_Name(static_cast<v1::ToolFlag>(flag)), "TOOL_FLAG_");
  }
  lines.push_back(line);
}

void add_timing(const v1::State& state, std::vector<std::string>& lines) {
  if (!state.has_timing()) return;
  const v1::Timing& t = state.timing();
  lines.push_back(
      format("tick CPU   p50 %.1f  p99 %.1f  p99.9 %.1f  max %.1f us   overruns %llu   input age "
             "%.1f us",
             kMicro * t.p50_ns(), kMicro * t.p99_ns(), kMicro * t.p999_ns(), kMicro * t.max_ns(),
             static_cast<unsigned long long>(t.overruns()), kMicro * t.input_age_ns()));
  for (const v1::StageTiming& stage : t.stages()) {
    lines.push_back(format("  %-10s p50 %.1f  p99 %.1f  p99.9 %.1f  max %.1f us",
                           plain_name(v1::Stage_Name(stage.stage()), "STAGE_").c_str(),
                           kMicro * stage.p50_ns(), kMicro * stage.p99_ns(),
                           kMicro * stage.p999_ns(), kMicro * stage.max_ns()));
  }
}

/// Why the quality is what it is; empty where the server does not say.
const char* words_of(v1::QualityReason reason) {
  switch (reason) {
    case v1::QUALITY_REASON_CHOSEN:
      return ", as asked for";
    case v1::QUALITY_REASON_ROOM:
      return ", the budget leaves room";
    case v1::QUALITY_REASON_BUDGET:
      return ", ticks came near the budget";
    case v1::QUALITY_REASON_SETTLING:
      return ", waits before it changes again";
    default:
      return "";
  }
}

/// The end of a noun of which there are so many.
const char* plural(std::uint64_t count) { return count == 1 ? "" : "s"; }

/// The work that a tick was allowed, and the CPU time it stands for where the server says.
std::string allowed_words(const v1::QualityState& quality) {
  if (quality.work_budget() == 0) return ", no bound";
  std::string work = format(" of %llu", static_cast<unsigned long long>(quality.work_budget()));
  if (!quality.has_budget_us()) return work;
  return work + format(" (%.4g us)", static_cast<double>(quality.budget_us()));
}

/// The quality in force and why, and what the tick shown did of what it was allowed.
void add_quality(const v1::State& state, std::vector<std::string>& lines) {
  if (!state.has_quality()) return;
  const v1::QualityState& quality = state.quality();
  lines.push_back(format("quality    level %u%s%s", quality.level(),
                         quality.automatic() ? " (auto)" : "", words_of(quality.reason())));
  lines.push_back(
      format("work       %llu%s   %u sub-step%s  %llu test%s  %u QP iteration%s%s",
             static_cast<unsigned long long>(quality.work()), allowed_words(quality).c_str(),
             quality.substeps(), plural(quality.substeps()),
             static_cast<unsigned long long>(quality.sphere_tests()),
             plural(quality.sphere_tests()), quality.qp_iterations(),
             plural(quality.qp_iterations()), quality.cut_short() ? "   cut short" : ""));
}

/// Share of the stiffness below which a hand hardly feels what it touches; the daemon warns of it.
constexpr float kHardlyFelt = 0.05F;

std::string lease_text(const v1::LeaseInfo& lease) {
  std::string text = lease.holder().empty() ? "taken" : "of " + lease.holder();
  if (!lease.key_name().empty()) text += ", with the key " + lease.key_name();
  if (!lease.reason().empty()) {
    text += ", taken over" + (lease.taken_from().empty() ? "" : " from " + lease.taken_from()) +
            ": " + lease.reason();
  }
  return text;
}

void add_rest(const View& view, std::vector<std::string>& lines) {
  const v1::State& state = view.state;
  for (const v1::StiffnessState& stiffness : state.stiffness()) {
    if (stiffness.scale() >= 1.0F) continue;
    lines.push_back(format("stiffness of %s clamped to %.3g %%: the device bears %.4g N/m%s",
                           tool_name(view, stiffness.tool_id()).c_str(),
                           100.0 * static_cast<double>(stiffness.scale()),
                           static_cast<double>(stiffness.bound_n_per_m()),
                           stiffness.scale() < kHardlyFelt
                               ? "; hardly any force is felt, the log of hapticd says why"
                               : ""));
  }
  add_quality(state, lines);
  for (const v1::GestureState& gesture : state.gestures()) {
    lines.push_back(format("gesture    %s %3.0f %%, %u done", gesture.name().c_str(),
                           100.0 * static_cast<double>(gesture.progress()),
                           gesture.repeated_count()));
  }
}

void add_contacts(const View& view, std::vector<std::string>& lines) {
  for (const v1::ContactPatch& contact : view.state.contacts()) {
    lines.push_back(format("contact    %-12s %6.3f N   gap %8.1f um",
                           wire::whole_characters(object_name(view, contact), 12).c_str(),
                           length(contact.force_w_n(), 0),
                           kMicro * at(contact.gap_nanometres(), 0)));
  }
}

void add_strings(const View& view, std::vector<std::string>& lines) {
  for (const v1::StringState& string : view.state.strings()) {
    lines.push_back(
        format("string     %-12s %-8s at %.3f   deflected %7.3f mm   drawn %7.3f mm",
               wire::whole_characters(string_name(view, string.string_index()), 12).c_str(),
               plain_name(v1::StringPhase_Name(string.phase()), "STRING_PHASE_").c_str(),
               static_cast<double>(string.lambda()), 1e3 * length(string.deflection_w_m(), 0),
               1e3 * static_cast<double>(string.radius_m())));
  }
}

void add_histogram(const TickHistogram& histogram, std::vector<std::string>& lines) {
  const std::uint64_t most = *std::max_element(histogram.counts.begin(), histogram.counts.end());
  if (most == 0) return;
  lines.push_back("ticks by CPU time:");
  for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
    const std::uint64_t count = histogram.counts[i];
    if (count == 0) continue;
    const bool last = i + 1 == histogram.counts.size();
    const auto stars = std::max<std::size_t>(
        1, static_cast<std::size_t>(static_cast<double>(count) / static_cast<double>(most) *
                                    static_cast<double>(kBarWidth)));
    lines.push_back(format("  %s %5u us %8llu ", last ? ">=" : " <", last ? 1U << (i - 1) : 1U << i,
                           static_cast<unsigned long long>(count)) +
                    std::string(stars, '#'));
  }
}

void add_tones(const View& view, std::vector<std::string>& lines) {
  for (const v1::Tone& tone : view.tones) {
    const double age = view.state.t_ns() > tone.t_ns()
                           ? 1e-9 * static_cast<double>(view.state.t_ns() - tone.t_ns())
                           : 0.0;
    lines.push_back(
        format("tone       %-12s %8.2f Hz   level %.2f   %6.1f s ago",
               wire::whole_characters(string_name(view, tone.string_index()), 12).c_str(),
               static_cast<double>(tone.frequency_hz()), static_cast<double>(tone.level()), age));
  }
}

void add_state(const View& view, std::vector<std::string>& lines) {
  lines.push_back(format("tick %llu, %.3f s", static_cast<unsigned long long>(view.state.tick()),
                         1e-9 * static_cast<double>(view.state.t_ns())));
  for (const v1::ToolState& tool : view.state.tools()) add_tool(view, tool, lines);
  add_timing(view.state, lines);
  add_rest(view, lines);
}

/// The names in them came from the daemon.
void show(std::vector<std::string>& lines) {
  for (std::string& line : lines) line = wire::shown_text(line);
}

}  // namespace

void TickHistogram::add(std::uint32_t ns) noexcept {
  std::size_t bin = 0;
  while (bin + 1 < counts.size() && ns >= 1000U << bin) ++bin;
  ++counts[bin];
}

std::vector<std::string> summary_lines(const View& view) {
  std::vector<std::string> lines{head_line(view)};
  if (view.has_state) add_state(view, lines);
  if (view.lease.fence() != 0) lines.push_back("lease      " + lease_text(view.lease));
  show(lines);
  return lines;
}

std::string network_line(const v1::Counts& counts) {
  std::string line = "network    datagrams: ";
  bool any = false;
  for (const v1::Count& count : counts.counts()) {
    if (count.count() == 0) continue;
    if (std::exchange(any, true)) line += ", ";
    line += wire::shown_text(count.cause()) + " " + std::to_string(count.count());
  }
  return any ? line : line + "none counted";
}

std::vector<std::string> screen_lines(const View& view, std::size_t columns, std::size_t rows) {
  std::vector<std::string> lines = summary_lines(view);
  if (view.silence_s > kSilence) {
    lines.insert(lines.begin() + 1, format("nothing heard for %.0f s", view.silence_s));
  }
  add_contacts(view, lines);
  add_strings(view, lines);
  add_tones(view, lines);
  add_histogram(view.ticks, lines);
  if (rows > 0 && lines.size() >= rows) lines.resize(rows - 1);
  lines.emplace_back("q quits");
  show(lines);
  for (std::string& line : lines) line = wire::whole_characters(line, columns);
  return lines;
}

}  // namespace hapticd::ctl
