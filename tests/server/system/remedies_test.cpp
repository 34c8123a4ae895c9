// The commands that the doctor gives, typed into a shell. Truth: the same machine, looked at again,
// has nothing to be mended. Its files stand for those of the kernel; sudo, sysctl and udevadm are
// stand-ins that change them.
#include <doctest/doctest.h>
#include <linux/capability.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "server/system/diagnosis.h"
#include "tests/server/system/made_up_machine.h"

namespace hapticd::test {
namespace {

void put_program(const MadeUpMachine& machine, const std::string& name, const std::string& body) {
  const std::string file = "bin/" + name;
  machine.write(file, "#!/bin/sh\n" + body + "\n");
  chmod((machine.root().root / file).c_str(), 0755);
}

/// `command` with the machine's own folders in place of those of this one.
std::string moved(const std::string& root, std::string command) {
  for (const char* folder : {"/sys/", "/proc/", "/etc/", "/dev/"}) {
    for (std::size_t at = command.find(folder); at != std::string::npos;
         at = command.find(folder, at + root.size() + 1)) {
      command.insert(at, root);
    }
  }
  return command;
}

/// Types `command`; whether it succeeded.
bool typed(const MadeUpMachine& machine, const std::string& command) {
  const std::string root = machine.root().root.string();
  put_program(machine, "sudo", "exec \"$@\"");
  put_program(machine, "sysctl",
              "[ \"$1\" = -w ] && name=${2%%=*} && file=" + root +
                  "/proc/sys/$(echo $name | tr . /) && [ -e $file ] && echo \"${2#*=}\" >$file");
  put_program(machine, "udevadm", "[ \"$*\" = 'control --reload' ] || [ \"$*\" = trigger ]");
  // Of a shell that holds a file open for good, the test needs the beginning.
  put_program(machine, "sleep", "[ \"$1\" = infinity ]");
  machine.write("typed.sh", moved(root, command) + "\n");
  const std::string shell =
      "PATH=" + root + "/bin:$PATH USER=somebody sh -e " + root + "/typed.sh >/dev/null 2>&1";
  // NOLINTNEXTLINE(cert-env33-c,concurrency-mt-unsafe): a shell is what is tested; one thread
  return std::system(shell.c_str()) == 0;
}

Finding finding_of(const MadeUpMachine& machine, const std::string& name,
                   const std::string& refused = "none") {
  HostReport report;
  report.facts = read_facts(machine.root(refused));
  for (const Finding& finding : diagnose(report)) {
    if (finding.name == name) return finding;
  }
  FAIL("there is no finding " << name);
  return {};
}

/// The command of a remedy, and the one in brackets behind it, which begins after `before`.
std::string command_of(const Finding& finding) {
  return finding.fix.substr(0, finding.fix.find("    ("));
}
std::string other_command_of(const Finding& finding, const std::string& before,
                             const std::string& end) {
  const std::size_t at = finding.fix.find(before);
  REQUIRE(at != std::string::npos);
  const std::size_t from = at + before.size();
  return finding.fix.substr(from, finding.fix.find(end, from) - from);
}

std::string text_of(const MadeUpMachine& machine, const std::string& file) {
  std::ifstream stream(machine.root().root / file);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

void check_mended(const MadeUpMachine& machine, const std::string& name) {
  const Finding before = finding_of(machine, name);
  CAPTURE(before.fix);
  REQUIRE(before.verdict != Verdict::kGood);
  CHECK(typed(machine, command_of(before)));
  CHECK(finding_of(machine, name).verdict == Verdict::kGood);
}

}  // namespace

TEST_CASE("what the doctor says of governor, clock, idle state and throttling mends them") {
  const MadeUpMachine machine;
  machine.write("sys/devices/system/cpu/cpu2/cpufreq/scaling_governor", "powersave\n");
  machine.write("sys/devices/system/cpu/cpu3/cpufreq/scaling_governor", "schedutil\n");
  machine.write("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n");
  for (const char* cpu : {"cpu0/", "cpu1/", "cpu2/", "cpu3/"}) {
    machine.idle_state(cpu, "state4", "C6", "133", "0");
  }
  machine.write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
  for (const std::string name : {"governor", "clocksource", "idle", "rt_throttling"}) {
    CAPTURE(name);
    check_mended(machine, name);
  }
}

TEST_CASE("holding the latency of idle processors, as the doctor says, is seen by it") {
  const MadeUpMachine machine;
  machine.idle_state("cpu3/", "state4", "C6", "133", "0");
  machine.write("dev/cpu_dma_latency", "");
  const Finding idle = finding_of(machine, "idle");
  CHECK(typed(machine, other_command_of(idle, "(or hold /dev/cpu_dma_latency: ", "')") + "'"));
  CHECK(finding_of(machine, "idle").verdict == Verdict::kGood);
}

TEST_CASE("limits of priority and memory are raised by what the doctor says, now and for good") {
  const MadeUpMachine machine;
  machine.write("proc/self/limits",
                "Max locked memory         65536                65536                bytes     \n"
                "Max realtime priority     0                    0                    \n");
  for (const std::string name : {"rtprio", "memlock"}) {
    CAPTURE(name);
    const Finding finding = finding_of(machine, name);
    REQUIRE(finding.verdict == Verdict::kCause);
    machine.write("etc/security/limits.d/90-hapticd-" + name + ".conf", "");
    CHECK(typed(machine, other_command_of(finding, "(for good: ", ", and log in again")));
    // As pam_limits reads it: who, which of both limits, what, how much.
    const bool priority = name == "rtprio";
    const std::string value = priority ? "90" : "unlimited";
    CHECK(text_of(machine, "etc/security/limits.d/90-hapticd-" + name + ".conf") ==
          "somebody - " + name + " " + value + "\n");
    const std::string letter = priority ? "r" : "l";
    const std::string command = command_of(finding);
    if (geteuid() == 0 && prctl(PR_CAPBSET_READ, CAP_SYS_RESOURCE) == 1) {
      CHECK(typed(machine, "ulimit -" + letter + " 0\n" + command + "\n[ \"$(ulimit -" + letter +
                               ")\" = " + value + " ]"));
    } else {
      // The kernel refuses it to who has no right; the command itself is understood.
      const std::string refused = priority ? "RTPRIO" : "MEMLOCK";
      CHECK(typed(machine, "export LC_ALL=C\nulimit -" + letter + " 0\n" + command +
                               " 2>&1 | grep -q '" + refused +
                               " resource limit: Operation not permitted'"));
    }
  }
}

TEST_CASE("interrupts and HID devices are dealt with by what the doctor says") {
  const MadeUpMachine machine;
  HostReport report;
  report.seconds = 1.0;
  report.cpu = 1;
  report.facts = read_facts(machine.root());
  report.before = read_counters(machine.root(), 1);
  report.after = report.before;
  for (auto& [name, count] : report.after.interrupts) count += 1'000'000;
  machine.write("proc/irq/24/smp_affinity_list", "0-3\n");
  bool found = false;
  for (const Finding& finding : diagnose(report)) {
    if (finding.name != "interrupts") continue;
    found = true;
    CAPTURE(finding.fix);
    CHECK(typed(machine, command_of(finding)));
  }
  CHECK(found);
  CHECK(text_of(machine, "proc/irq/24/smp_affinity_list") == "0\n");

  machine.write("sys/class/hidraw/hidraw0/device/uevent", "HID_NAME=Maker Handle\n");
  machine.write("dev/hidraw0", "");
  machine.write("etc/udev/rules.d/70-hapticd.rules", "");
  CHECK(typed(machine, command_of(finding_of(machine, "hidraw", "hidraw0"))));
  CHECK(text_of(machine, "etc/udev/rules.d/70-hapticd.rules") ==
        "KERNEL==\"hidraw*\", SUBSYSTEM==\"hidraw\", TAG+=\"uaccess\"\n");
}

}  // namespace hapticd::test
