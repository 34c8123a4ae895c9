// A machine that is only files: /proc, /sys and /dev of a healthy one in a folder of their own, to
// be spoiled file by file. The formats are those of proc(5) and of the kernel's ABI documents.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "server/system/host_facts.h"

namespace hapticd::test {

class MadeUpMachine {
 public:
  MadeUpMachine() {
    std::string pattern = (std::filesystem::temp_directory_path() / "hapticd_host_XXXXXX").string();
    root_ = mkdtemp(pattern.data());
    write("proc/self/limits",
          "Limit                     Soft Limit           Hard Limit           Units     \n"
          "Max locked memory         unlimited            unlimited            bytes     \n"
          "Max realtime priority     90                   90                   \n");
    write("proc/self/status", "Name:\thapticd\nCapEff:\t0000000000000000\n");
    write("proc/cpuinfo", "model name\t: A Processor\nflags\t\t: fpu avx2\n");
    write("proc/version", "Linux version 6.1.0-rt (builder) #1 SMP PREEMPT_RT Debian\n");
    write("proc/sys/kernel/sched_rt_runtime_us", "-1\n");
    write("proc/sys/kernel/sched_rt_period_us", "1000000\n");
    write("proc/stat", "cpu  100 0 50 1000 10 0 5 7 0 0\ncpu0 50 0 25 500 5 0 2 3 0 0\n");
    write("proc/interrupts",
          "           CPU0       CPU1\n"
          "  24:          5        100  IO-APIC   5-edge      disk\n"
          " LOC:    1000000    2000000   Local timer interrupts\n");
    write("sys/kernel/realtime", "1\n");
    const std::string cpus = "sys/devices/system/cpu/";
    write(cpus + "online", "0-3\n");
    for (const char* cpu : {"cpu0/", "cpu1/", "cpu2/", "cpu3/"}) {
      write(cpus + cpu + "cpufreq/scaling_governor", "performance\n");
      idle_state(cpu, "state0", "POLL", "0", "0");
      idle_state(cpu, "state1", "C1", "2", "0");
    }
    const std::string clock = "sys/devices/system/clocksource/clocksource0/";
    write(clock + "current_clocksource", "tsc\n");
    write(clock + "available_clocksource", "tsc hpet acpi_pm\n");
  }
  MadeUpMachine(const MadeUpMachine&) = delete;
  MadeUpMachine& operator=(const MadeUpMachine&) = delete;
  ~MadeUpMachine() {
    std::error_code none;
    std::filesystem::remove_all(root_, none);
  }

  void write(const std::string& file, const std::string& text) const {
    const std::filesystem::path path = root_ / file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
  }
  void idle_state(const std::string& cpu, const std::string& state, const std::string& name,
                  const std::string& latency_us, const std::string& disabled) const {
    const std::string folder = "sys/devices/system/cpu/" + cpu + "cpuidle/" + state + "/";
    write(folder + "name", name + "\n");
    write(folder + "latency", latency_us + "\n");
    write(folder + "disable", disabled + "\n");
  }
  void remove(const std::string& file) const { std::filesystem::remove_all(root_ / file); }

  /// Where it is; files named `refused` may not be used.
  [[nodiscard]] ProbeRoot root(const std::string& refused = "none") const {
    ProbeRoot root;
    root.root = root_;
    root.may_use = [refused](const std::filesystem::path& file) {
      return file.filename() != refused;
    };
    return root;
  }

 private:
  std::filesystem::path root_;
};

}  // namespace hapticd::test
