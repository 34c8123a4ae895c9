// See host_facts.h. Formats: proc(5), Documentation/ABI/testing of the kernel.
#include "server/system/host_facts.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <fstream>
#include <sstream>

namespace hapticd {
namespace {

namespace fs = std::filesystem;

/// Bits of CapEff, capabilities(7).
constexpr unsigned kCapIpcLock = 14;
constexpr unsigned kCapSysNice = 23;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::stringstream text;
  if (stream) text << stream.rdbuf();
  return text.str();
}

std::string line_of(const fs::path& file) {
  const std::string text = text_of(file);
  return text.substr(0, text.find('\n'));
}

std::optional<std::int64_t> number_of(const std::string& text) {
  std::istringstream stream(text);
  std::int64_t number = 0;
  if (!(stream >> number)) return std::nullopt;
  return number;
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// What follows `key` and a colon in a file of such lines.
std::string value_of(const std::string& text, const std::string& key) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(key, 0) != 0) continue;
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) continue;
    const std::size_t begin = line.find_first_not_of(" \t", colon + 1);
    return begin == std::string::npos ? "" : line.substr(begin);
  }
  return "";
}

/// "0-2,5" as 0 1 2 5.
std::vector<int> list_of(const std::string& text) {
  std::vector<int> list;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) {
    std::istringstream range(part);
    int first = 0;
    int last = 0;
    char dash = '-';
    if (!(range >> first)) continue;
    if (!(range >> dash >> last)) last = first;
    for (int each = first; each <= last && list.size() < 4096; ++each) list.push_back(each);
  }
  return list;
}

/// Names in a folder, in order; none where there is no such folder.
std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// Soft limit of /proc/self/limits.
std::optional<std::int64_t> limit_of(const std::string& limits, const std::string& name) {
  const std::size_t at = limits.find(name);
  if (at == std::string::npos) return std::nullopt;
  const std::vector<std::string> words = words_of(limits.substr(at + name.size(), 60));
  if (words.empty()) return std::nullopt;
  return words[0] == "unlimited" ? kNoLimit : number_of(words[0]);
}

bool has_capability(const std::string& status, unsigned bit) {
  std::istringstream stream(value_of(status, "CapEff"));
  std::uint64_t bits = 0;
  stream >> std::hex >> bits;
  return ((bits >> bit) & 1U) != 0;
}

void read_rights(const fs::path& root, HostFacts& facts) {
  const std::string limits = text_of(root / "proc/self/limits");
  const std::string status = text_of(root / "proc/self/status");
  facts.highest_priority = limit_of(limits, "Max realtime priority");
  facts.lockable_bytes = limit_of(limits, "Max locked memory");
  if (has_capability(status, kCapSysNice)) facts.highest_priority = 99;
  if (has_capability(status, kCapIpcLock)) facts.lockable_bytes = kNoLimit;
}

void read_idle_states(const fs::path& folder, HostFacts& facts) {
  for (const std::string& name : names_in(folder)) {
    if (name.rfind("state", 0) != 0) continue;
    const fs::path state = folder / name;
    if (number_of(line_of(state / "disable")).value_or(0) != 0) continue;
    const std::int64_t latency = number_of(line_of(state / "latency")).value_or(0);
    if (facts.slowest_idle && facts.slowest_idle->latency_us >= latency) continue;
    facts.slowest_idle = IdleState{line_of(state / "name"), latency, name.substr(5)};
  }
}

void read_processors(const fs::path& root, HostFacts& facts) {
  const fs::path cpus = root / "sys/devices/system/cpu";
  const std::string info = text_of(root / "proc/cpuinfo");
  facts.processor = value_of(info, "model name");
  facts.processors = list_of(line_of(cpus / "online"));
  const std::vector<std::string> flags = words_of(value_of(info, "flags"));
  facts.hypervisor = std::find(flags.begin(), flags.end(), "hypervisor") != flags.end() ||
                     !line_of(root / "sys/hypervisor/type").empty();
  for (const int cpu : facts.processors) {
    const fs::path folder = cpus / ("cpu" + std::to_string(cpu));
    const std::string governor = line_of(folder / "cpufreq/scaling_governor");
    if (!governor.empty()) ++facts.governors[governor];
    read_idle_states(folder / "cpuidle", facts);
  }
  const std::string latency = text_of(root / "dev/cpu_dma_latency");
  std::int32_t us = 0;
  if (latency.size() >= sizeof(us)) {
    std::memcpy(&us, latency.data(), sizeof(us));
    facts.dma_latency = us;
  }
  const fs::path clock = root / "sys/devices/system/clocksource/clocksource0";
  facts.clock_source = line_of(clock / "current_clocksource");
  facts.clock_sources = words_of(line_of(clock / "available_clocksource"));
}

void read_kernel(const fs::path& root, HostFacts& facts) {
  const std::vector<std::string> version = words_of(line_of(root / "proc/version"));
  if (version.size() > 2) facts.kernel = version[0] + " " + version[2];
  facts.realtime_kernel = number_of(line_of(root / "sys/kernel/realtime")).value_or(0) == 1 ||
                          std::find(version.begin(), version.end(), "PREEMPT_RT") != version.end();
  facts.rt_runtime_us = number_of(line_of(root / "proc/sys/kernel/sched_rt_runtime_us"));
  facts.rt_period_us = number_of(line_of(root / "proc/sys/kernel/sched_rt_period_us"));
}

void read_hidraw(const ProbeRoot& root, HostFacts& facts) {
  for (const std::string& name : names_in(root.root / "sys/class/hidraw")) {
    HidrawAccess node;
    node.file = "/dev/" + name;
    std::string event = text_of(root.root / "sys/class/hidraw" / name / "device/uevent");
    std::replace(event.begin(), event.end(), '=', ':');
    node.name = value_of(event, "HID_NAME");
    const fs::path file = root.root / "dev" / name;
    node.usable = root.may_use ? root.may_use(file) : access(file.c_str(), R_OK | W_OK) == 0;
    facts.hidraw.push_back(std::move(node));
  }
}

/// Rows of /proc/interrupts with a number: those of devices.
void read_interrupts(const fs::path& root, std::uint32_t cpu, HostCounters& counters) {
  std::istringstream lines(text_of(root / "proc/interrupts"));
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> heads = words_of(line);
  const auto found = std::find(heads.begin(), heads.end(), "CPU" + std::to_string(cpu));
  if (found == heads.end()) return;
  const auto column = static_cast<std::size_t>(found - heads.begin());
  while (std::getline(lines, line)) {
    const std::vector<std::string> words = words_of(line);
    if (words.size() < heads.size() + 2 || std::isdigit(words[0].front()) == 0) continue;
    const std::string number = words[0].substr(0, words[0].find(':'));
    counters.interrupts[number + " " + words.back()] = number_of(words[column + 1]).value_or(0);
  }
}

}  // namespace

HostFacts read_facts(const ProbeRoot& root) {
  HostFacts facts;
  read_rights(root.root, facts);
  read_processors(root.root, facts);
  read_kernel(root.root, facts);
  read_hidraw(root, facts);
  return facts;
}

HostCounters read_counters(const ProbeRoot& root, std::optional<std::uint32_t> cpu) {
  HostCounters counters;
  // cpu user nice system idle iowait irq softirq steal guest guest_nice; guests are in user.
  const std::vector<std::string> words = words_of(line_of(root.root / "proc/stat"));
  for (std::size_t k = 1; k < words.size() && k <= 8; ++k) {
    const std::int64_t ticks = number_of(words[k]).value_or(0);
    counters.all += ticks;
    if (k == 4 || k == 5) counters.idle += ticks;
    if (k == 8) counters.steal = ticks;
  }
  if (cpu) read_interrupts(root.root, *cpu, counters);
  return counters;
}

}  // namespace hapticd
