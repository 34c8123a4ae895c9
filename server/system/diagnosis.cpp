// See diagnosis.h.
#include "server/system/diagnosis.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>

#include "server/haptic_loop/thread_policy.h"

namespace hapticd {
namespace {

/// Highest priority the daemon asks for: that of its guardian.
constexpr std::int64_t kPriorityNeeded = kLoopPriority + 1;
/// Clock sources that are read without entering the kernel.
constexpr std::array<std::string_view, 5> kFastClocks{
    "tsc", "kvm-clock", "hyperv_clocksource_tsc_page", "xen", "arch_sys_counter"};

std::string percent(double share) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2f %%", 100.0 * share);
  return text.data();
}

std::string microseconds(std::int64_t ns) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.0f us", 1e-3 * static_cast<double>(ns));
  return text.data();
}

class Diagnosis {
 public:
  explicit Diagnosis(const HostReport& report) : report_(report), facts_(report.facts) {}

  void look_at_timer();
  void look_at_work();
  void look_at_rights();
  void look_at_kernel();
  void look_at_processors();
  void look_at_idle();
  void look_at_hypervisor();
  void look_at_interrupts();
  void look_at_hidraw();

  std::vector<Finding> findings;

 private:
  void good(const char* name, std::string what) {
    findings.push_back({Verdict::kGood, name, std::move(what), ""});
  }
  void hint(const char* name, std::string what, std::string fix) {
    findings.push_back({Verdict::kHint, name, std::move(what), std::move(fix)});
  }
  void cause(const char* name, std::string what, std::string fix) {
    findings.push_back({Verdict::kCause, name, std::move(what), std::move(fix)});
  }

  const HostReport& report_;
  const HostFacts& facts_;
};

void Diagnosis::look_at_timer() {
  const TimerMeasurement& timer = report_.timer;
  if (report_.seconds <= 0.0 || timer.ticks == 0) return;
  const LatencySummary late = summarise(timer.late);
  const std::string times = "woken " + microseconds(late.p99_ns) +
                            " late or less in 99 of 100 ticks, " + microseconds(late.p99_9_ns) +
                            " in 999 of 1000, " + microseconds(late.max_ns) + " at worst";
  if (timer.skipped > 0) {
    cause("timer",
          times + "; " + std::to_string(timer.skipped) + " of " +
              std::to_string(timer.ticks + timer.skipped) + " ticks were lost",
          "fix the causes named below, then run 'top -H -d 1' to see what else runs");
  } else if (late.p99_9_ns > timer.period_ns / 2) {
    cause("timer", times + ": more than half a period",
          "fix the causes named below, then run 'top -H -d 1' to see what else runs");
  } else {
    good("timer", times);
  }
}

void Diagnosis::look_at_work() {
  const TimerMeasurement& timer = report_.timer;
  if (report_.seconds <= 0.0 || timer.work.total == 0) return;
  const LatencySummary work = summarise(timer.work);
  const std::string times = "work of " + microseconds(work.p50_ns) + " took " +
                            microseconds(work.p99_9_ns) + " or less in 999 of 1000 ticks, " +
                            microseconds(work.max_ns) + " at worst";
  const double beyond = static_cast<double>(work.max_ns - work.p50_ns);
  if (beyond <= kHoldUpAllowed * static_cast<double>(timer.period_ns)) {
    good("hold_up", times);
    return;
  }
  cause("hold_up",
        times + ", longer than a period in " + std::to_string(timer.held_up) + " of " +
            std::to_string(timer.ticks) +
            " ticks: something below the kernel stops a thread that runs",
        "sudo apt-get install rt-tests && sudo hwlatdetect --duration=60    (names the firmware; "
        "else it is the hypervisor: see steal)");
}

void Diagnosis::look_at_rights() {
  const bool fifo_granted = report_.seconds > 0.0 && report_.timer.fifo;
  if (facts_.highest_priority || fifo_granted) {
    const std::int64_t priority = facts_.highest_priority.value_or(0);
    if (fifo_granted || priority >= kPriorityNeeded) {
      good("rtprio", "SCHED_FIFO is permitted");
    } else {
      cause("rtprio",
            "SCHED_FIFO is permitted up to priority " + std::to_string(priority) + ", " +
                std::to_string(kPriorityNeeded) + " is needed: anything that runs delays the loop",
            "sudo prlimit --pid $$ --rtprio=90:90    (for good: echo \"$USER - rtprio 90\" | sudo "
            "tee /etc/security/limits.d/90-hapticd-rtprio.conf, and log in again; in a service: "
            "LimitRTPRIO=90)");
    }
  }
  if (!facts_.lockable_bytes) return;
  const std::int64_t bytes = *facts_.lockable_bytes;
  if (bytes >= kLockedBytes) {
    good("memlock", "memory can be locked");
    return;
  }
  cause(
      "memlock",
      "only " + std::to_string(bytes / 1024) + " KiB of memory can be locked, " +
          std::to_string(kLockedBytes / 1024) + " are needed: a page fault stops the loop",
      "sudo prlimit --pid $$ --memlock=unlimited:unlimited    (for good: echo \"$USER - memlock "
      "unlimited\" | sudo tee /etc/security/limits.d/90-hapticd-memlock.conf, and log in again; in "
      "a service: LimitMEMLOCK=infinity)");
}

void Diagnosis::look_at_kernel() {
  if (facts_.rt_runtime_us) {
    const std::int64_t runtime = *facts_.rt_runtime_us;
    const std::int64_t period = facts_.rt_period_us.value_or(1'000'000);
    const std::string fix = "sudo sysctl -w kernel.sched_rt_runtime_us=-1";
    const std::string share = std::to_string(runtime) + " of " + std::to_string(period) + " us";
    if (runtime < 0) {
      good("rt_throttling", "realtime threads are not throttled");
    } else if (2 * runtime < period) {
      cause("rt_throttling", "realtime threads may run for " + share + ", then they are stopped",
            fix);
    } else {
      hint("rt_throttling",
           "realtime threads may run for " + share + ": harmless while ticks stay within it", fix);
    }
  }
  if (facts_.kernel.empty()) return;
  if (facts_.realtime_kernel) {
    good("kernel", facts_.kernel + ", PREEMPT_RT");
  } else {
    hint("kernel", facts_.kernel + " is not a PREEMPT_RT kernel: single ticks may be late by a ms",
         "sudo apt-get install linux-image-rt-amd64    (and boot it)");
  }
}

void Diagnosis::look_at_processors() {
  const std::size_t count = facts_.processors.size();
  if (count == 1) {
    cause("processors", "one processor serves the loop and everything else",
          "give the machine a second processor");
  } else if (count > 1) {
    const bool there =
        !report_.cpu || std::count(facts_.processors.begin(), facts_.processors.end(),
                                   static_cast<int>(*report_.cpu)) > 0;
    if (there) {
      good("processors", std::to_string(count) + " processors");
    } else {
      cause("processors", "processor " + std::to_string(*report_.cpu) + " is not there",
            "name one of /sys/devices/system/cpu/online with --cpu");
    }
  }
  const auto performance = facts_.governors.find("performance");
  const bool others = facts_.governors.size() > (performance == facts_.governors.end() ? 0U : 1U);
  if (others) {
    std::string names;
    for (const auto& [name, processors] : facts_.governors) {
      if (name != "performance") names += (names.empty() ? "" : ", ") + name;
    }
    cause("governor", "the frequency follows the load (" + names + "): a short tick runs slowly",
          "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor");
  } else if (performance != facts_.governors.end()) {
    good("governor", "processors keep their highest frequency");
  }
  if (facts_.clock_source.empty()) return;
  const std::string& clock = facts_.clock_source;
  if (std::count(kFastClocks.begin(), kFastClocks.end(), clock) > 0) {
    good("clocksource", "the clock is " + clock);
    return;
  }
  const bool tsc = std::count(facts_.clock_sources.begin(), facts_.clock_sources.end(), "tsc") > 0;
  cause("clocksource", "the clock is " + clock + ": each reading of it enters the kernel",
        tsc ? "echo tsc | sudo tee "
              "/sys/devices/system/clocksource/clocksource0/current_clocksource"
            : "boot with tsc=reliable (in /etc/default/grub, then sudo update-grub)");
}

void Diagnosis::look_at_idle() {
  if (!facts_.slowest_idle) return;
  const IdleState& state = *facts_.slowest_idle;
  const bool held = facts_.dma_latency && *facts_.dma_latency < state.latency_us;
  const std::int64_t latency = held ? *facts_.dma_latency : state.latency_us;
  if (latency <= kIdleLatency_us) {
    good("idle", "idle processors wake up within " + std::to_string(latency) + " us");
    return;
  }
  cause(
      "idle",
      "an idle processor in " + state.name + " takes " + std::to_string(latency) + " us to wake up",
      "echo 1 | sudo tee /sys/devices/system/cpu/cpu*/cpuidle/state" + state.number +
          "/disable    (or hold /dev/cpu_dma_latency: sudo sh -c 'exec 3>/dev/cpu_dma_latency; "
          "printf \"\\024\\000\\000\\000\" >&3; exec sleep infinity')");
}

void Diagnosis::look_at_hypervisor() {
  const auto all = static_cast<double>(report_.after.all - report_.before.all);
  const bool measured = report_.seconds > 0.0 && all > 0.0;
  const double steal =
      measured ? static_cast<double>(report_.after.steal - report_.before.steal) / all : 0.0;
  if (steal > kStealAllowed) {
    cause("steal", "the hypervisor took " + percent(steal) + " of the time away",
          "on the host: virsh vcpupin DOMAIN VCPU CPU, a processor for each; or run on hardware");
  } else if (facts_.hypervisor) {
    hint("steal",
         "this is a virtual machine" +
             (measured ? ", which lost " + percent(steal) + " of the time" : std::string()) +
             ": its host decides how punctual it is",
         "on the host: virsh vcpupin DOMAIN VCPU CPU, a processor for each; or run on hardware");
  } else if (!facts_.processor.empty()) {
    good("steal", "no hypervisor");
  }
  if (!measured) return;
  const double busy = 1.0 - static_cast<double>(report_.after.idle - report_.before.idle) / all;
  if (busy > kBusyAllowed) {
    hint("load", "the processors were busy for " + percent(busy) + " of the time",
         "top -H -d 1    (shows with what)");
  } else {
    good("load", "the processors were busy for " + percent(busy) + " of the time");
  }
}

void Diagnosis::look_at_interrupts() {
  if (!report_.cpu || report_.seconds <= 0.0 || report_.after.interrupts.empty()) return;
  double rate = 0.0;
  double most = 0.0;
  std::string busiest;
  for (const auto& [name, count] : report_.after.interrupts) {
    const auto before = report_.before.interrupts.find(name);
    const std::int64_t old = before == report_.before.interrupts.end() ? 0 : before->second;
    const double each = static_cast<double>(count - old) / report_.seconds;
    rate += each;
    if (each > most) {
      most = each;
      busiest = name;
    }
  }
  const std::string on = "processor " + std::to_string(*report_.cpu) + " serves " +
                         std::to_string(static_cast<std::int64_t>(rate)) +
                         " interrupts of devices a second";
  const auto other = std::find_if(facts_.processors.begin(), facts_.processors.end(),
                                  [&](int cpu) { return cpu != static_cast<int>(*report_.cpu); });
  if (rate <= kInterruptsAllowed || other == facts_.processors.end()) {
    good("interrupts", on);
    return;
  }
  hint("interrupts", on + ", most of " + busiest,
       "echo " + std::to_string(*other) + " | sudo tee /proc/irq/" +
           busiest.substr(0, busiest.find(' ')) + "/smp_affinity_list");
}

void Diagnosis::look_at_hidraw() {
  std::string refused;
  for (const HidrawAccess& node : facts_.hidraw) {
    if (node.usable) continue;
    refused += (refused.empty() ? "" : ", ") + node.file;
    if (!node.name.empty()) refused += " (" + node.name + ")";
  }
  if (refused.empty()) {
    good("hidraw",
         facts_.hidraw.empty() ? "no HID device is attached" : "the HID devices may be used");
    return;
  }
  hint("hidraw", "no permission to use " + refused + ": matters if one is the haptic device",
       "echo 'KERNEL==\"hidraw*\", SUBSYSTEM==\"hidraw\", TAG+=\"uaccess\"' | sudo tee "
       "/etc/udev/rules.d/70-hapticd.rules && sudo udevadm control --reload && sudo udevadm "
       "trigger");
}

}  // namespace

std::vector<Finding> diagnose(const HostReport& report) {
  Diagnosis diagnosis(report);
  diagnosis.look_at_timer();
  diagnosis.look_at_work();
  diagnosis.look_at_rights();
  diagnosis.look_at_kernel();
  diagnosis.look_at_processors();
  diagnosis.look_at_idle();
  diagnosis.look_at_hypervisor();
  diagnosis.look_at_interrupts();
  diagnosis.look_at_hidraw();
  return std::move(diagnosis.findings);
}

bool fit(const std::vector<Finding>& findings) noexcept {
  return std::none_of(findings.begin(), findings.end(),
                      [](const Finding& each) { return each.verdict == Verdict::kCause; });
}

}  // namespace hapticd
