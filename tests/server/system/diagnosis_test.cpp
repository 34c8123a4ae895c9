// Every cause the doctor can name, each made up and each mended. Truth: the machine was healthy
// until one file of it was spoiled, so that one finding and no other may change.
#include "server/system/diagnosis.h"

#include <doctest/doctest.h>

#include <set>

#include "tests/server/system/made_up_machine.h"

namespace hapticd::test {
namespace {

/// A machine that kept time for 10 s.
HostReport punctual(const MadeUpMachine& machine, const std::string& refused = "none") {
  HostReport report;
  report.facts = read_facts(machine.root(refused));
  report.seconds = 10.0;
  for (int k = 0; k < 10000; ++k) {
    record(report.timer.late, 20'000);
    record(report.timer.work, 50'000);
  }
  report.timer.ticks = 10000;
  report.cpu = 1;
  machine.write("proc/stat", "cpu  100 0 50 1000 10 0 5 7 0 0\n");
  report.before = read_counters(machine.root(), report.cpu);
  machine.write("proc/stat", "cpu  200 0 150 2600 10 0 5 7 0 0\n");
  report.after = read_counters(machine.root(), report.cpu);
  return report;
}

Finding find(const std::vector<Finding>& findings, const std::string& name) {
  for (const Finding& finding : findings) {
    if (finding.name == name) return finding;
  }
  return {Verdict::kGood, "", "", ""};
}

/// `name` alone is not good, with this verdict, and its fix has `command` in it.
void check_only(const HostReport& report, const std::string& name, Verdict verdict,
                const std::string& command) {
  const std::vector<Finding> findings = diagnose(report);
  CHECK(find(findings, name).name == name);
  for (const Finding& finding : findings) {
    CAPTURE(finding.name);
    CAPTURE(finding.what);
    if (finding.name == name) {
      CHECK(finding.verdict == verdict);
      CHECK(finding.fix.find(command) != std::string::npos);
    } else {
      CHECK(finding.verdict == Verdict::kGood);
    }
  }
  CHECK(fit(findings) == (verdict != Verdict::kCause));
}

TEST_CASE("a healthy machine has nothing but good findings, one of each kind") {
  const MadeUpMachine machine;
  const std::vector<Finding> findings = diagnose(punctual(machine));
  std::set<std::string> names;
  for (const Finding& finding : findings) {
    CAPTURE(finding.name);
    CHECK(finding.verdict == Verdict::kGood);
    CHECK(finding.fix.empty());
    names.insert(finding.name);
  }
  CHECK(names == std::set<std::string>{"timer", "hold_up", "rtprio", "memlock", "rt_throttling",
                                       "kernel", "processors", "governor", "clocksource", "idle",
                                       "steal", "load", "interrupts", "hidraw"});
  CHECK(fit(findings));
}

TEST_CASE("a machine that tells nothing of itself is not accused of anything") {
  MadeUpMachine machine;
  machine.remove("proc");
  machine.remove("sys");
  HostReport report;
  report.facts = read_facts(machine.root());
  for (const Finding& finding : diagnose(report)) {
    CAPTURE(finding.name);
    CHECK(finding.verdict == Verdict::kGood);
  }
}

TEST_CASE("ticks that were lost or woken late are a cause of their own") {
  const MadeUpMachine machine;
  HostReport report = punctual(machine);
  report.timer.skipped = 3;
  check_only(report, "timer", Verdict::kCause, "top");
  report.timer.skipped = 0;
  for (int k = 0; k < 20; ++k) record(report.timer.late, 600'000);
  check_only(report, "timer", Verdict::kCause, "top");
}

TEST_CASE("a machine that stops a thread which runs is named, once it takes half a period") {
  const MadeUpMachine machine;
  HostReport report = punctual(machine);
  record(report.timer.work, 400'000);
  CHECK(fit(diagnose(report)));
  record(report.timer.work, 700'000);
  check_only(report, "hold_up", Verdict::kCause, "hwlatdetect");
}

TEST_CASE(
    "a limit of realtime priority below what the guardian needs is named, unless a capability "
    "lifts it") {
  const MadeUpMachine machine;
  const std::string memory = "Max locked memory         unlimited            unlimited  bytes\n";
  machine.write("proc/self/limits", memory + "Max realtime priority     80   80   \n");
  check_only(punctual(machine), "rtprio", Verdict::kCause, "sudo prlimit --pid $$ --rtprio=90:90");
  machine.write("proc/self/status", "CapEff:\t0000000000800000\n");
  CHECK(fit(diagnose(punctual(machine))));
  machine.write("proc/self/status", "CapEff:\t0000000000000000\n");
  machine.write("proc/self/limits", memory + "Max realtime priority     81   81   \n");
  CHECK(fit(diagnose(punctual(machine))));
}

TEST_CASE("a limit of locked memory is named, unless a capability lifts it") {
  const MadeUpMachine machine;
  machine.write("proc/self/limits",
                "Max locked memory         8388608              8388608              bytes\n"
                "Max realtime priority     90                   90\n");
  check_only(punctual(machine), "memlock", Verdict::kCause, "sudo prlimit --pid $$ --memlock=");
  machine.write("proc/self/status", "CapEff:\t0000000000004000\n");
  CHECK(fit(diagnose(punctual(machine))));
}

TEST_CASE("throttling of realtime threads is a hint, and a cause where it takes half the time") {
  const MadeUpMachine machine;
  machine.write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
  const std::string command = "sudo sysctl -w kernel.sched_rt_runtime_us=-1";
  check_only(punctual(machine), "rt_throttling", Verdict::kHint, command);
  machine.write("proc/sys/kernel/sched_rt_runtime_us", "0\n");
  check_only(punctual(machine), "rt_throttling", Verdict::kCause, command);
}

TEST_CASE("a kernel without PREEMPT_RT is a hint") {
  const MadeUpMachine machine;
  machine.write("proc/version", "Linux version 6.1.0 (builder) #1 SMP PREEMPT_DYNAMIC Debian\n");
  machine.write("sys/kernel/realtime", "0\n");
  check_only(punctual(machine), "kernel", Verdict::kHint, "linux-image-rt");
  machine.write("sys/kernel/realtime", "1\n");
  CHECK(find(diagnose(punctual(machine)), "kernel").verdict == Verdict::kGood);
}

TEST_CASE("one processor, or one that is not there, is a cause") {
  const MadeUpMachine machine;
  machine.write("sys/devices/system/cpu/online", "0-1,3\n");
  HostReport report = punctual(machine);
  CHECK(report.facts.processors == std::vector<int>{0, 1, 3});
  report.cpu = 2;
  check_only(report, "processors", Verdict::kCause, "--cpu");
  machine.write("sys/devices/system/cpu/online", "0\n");
  report = punctual(machine);
  report.cpu.reset();
  check_only(report, "processors", Verdict::kCause, "second processor");
}

TEST_CASE("a governor that follows the load is named, be it on one processor of four") {
  const MadeUpMachine machine;
  machine.write("sys/devices/system/cpu/cpu2/cpufreq/scaling_governor", "powersave\n");
  check_only(punctual(machine), "governor", Verdict::kCause,
             "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor");
}

TEST_CASE("a clock that enters the kernel is named, with tsc where the machine has it") {
  const MadeUpMachine machine;
  const std::string clock = "sys/devices/system/clocksource/clocksource0/";
  machine.write(clock + "current_clocksource", "hpet\n");
  check_only(punctual(machine), "clocksource", Verdict::kCause, "echo tsc | sudo tee /sys/");
  machine.write(clock + "available_clocksource", "hpet acpi_pm\n");
  check_only(punctual(machine), "clocksource", Verdict::kCause, "tsc=reliable");
}

TEST_CASE("a slow idle state is named until it is disabled or somebody bounds the latency") {
  const MadeUpMachine machine;
  machine.idle_state("cpu3/", "state4", "C6", "133", "0");
  check_only(punctual(machine), "idle", Verdict::kCause, "cpuidle/state4/disable");
  machine.write("dev/cpu_dma_latency", std::string("\x14\0\0\0", 4));
  CHECK(fit(diagnose(punctual(machine))));
  machine.write("dev/cpu_dma_latency", std::string("\0\x94\x35\x77", 4));  // 2e9: nobody does
  CHECK(!fit(diagnose(punctual(machine))));
  machine.idle_state("cpu3/", "state4", "C6", "133", "1");
  CHECK(fit(diagnose(punctual(machine))));
}

TEST_CASE("a hypervisor is a hint, and a cause once it takes time away") {
  const MadeUpMachine machine;
  machine.write("proc/cpuinfo", "model name\t: A Processor\nflags\t\t: fpu hypervisor avx2\n");
  check_only(punctual(machine), "steal", Verdict::kHint, "vcpupin");
  HostReport report = punctual(machine);
  // 10 of 1800 clock ticks.
  report.after.steal += 10;
  report.after.all += 10;
  check_only(report, "steal", Verdict::kCause, "vcpupin");
}

TEST_CASE("busy processors are a hint") {
  const MadeUpMachine machine;
  HostReport report = punctual(machine);
  report.after.all += 10 * (report.after.all - report.before.all);
  check_only(report, "load", Verdict::kHint, "top");
}

TEST_CASE(
    "interrupts on the loop's processor are a hint that names the busiest and where to send it") {
  const MadeUpMachine machine;
  HostReport report = punctual(machine);
  machine.write("proc/interrupts",
                "           CPU0       CPU1\n"
                "  24:     900005      2100  IO-APIC   5-edge      disk\n"
                "  25:          0        40  IO-APIC   6-edge      net\n"
                " LOC:    1000000    9000000   Local timer interrupts\n");
  report.after.interrupts = read_counters(machine.root(), 1).interrupts;
  check_only(report, "interrupts", Verdict::kHint,
             "echo 0 | sudo tee /proc/irq/24/smp_affinity_list");
  report.seconds = 100.0;
  CHECK(find(diagnose(report), "interrupts").verdict == Verdict::kGood);
}

TEST_CASE(
    "a HID device that may not be used is a hint with its name and the rule that permits it") {
  const MadeUpMachine machine;
  machine.write("sys/class/hidraw/hidraw0/device/uevent", "DRIVER=hid\nHID_NAME=Maker Handle\n");
  machine.write("sys/class/hidraw/hidraw1/device/uevent", "HID_NAME=Keyboard\n");
  machine.write("dev/hidraw0", "");
  const HostReport report = punctual(machine, "hidraw0");
  check_only(report, "hidraw", Verdict::kHint, "/etc/udev/rules.d/70-hapticd.rules");
  CHECK(find(diagnose(report), "hidraw").what.find("/dev/hidraw0 (Maker Handle):") !=
        std::string::npos);
  CHECK(find(diagnose(punctual(machine)), "hidraw").verdict == Verdict::kGood);
}

}  // namespace
}  // namespace hapticd::test
