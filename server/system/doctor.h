// hapticd doctor: measures the host for some seconds and says what is wrong with it and how to fix
// it. Needs no privilege and no running daemon. Not RT.
#pragma once

#include <string>

#include "server/system/diagnosis.h"

namespace hapticd {

/// Exit codes of the doctor.
inline constexpr int kDoctorFit = 0;
inline constexpr int kDoctorUsage = 2;  ///< the command line makes no sense
inline constexpr int kDoctorUnfit = 6;  ///< causes were named

/// The report for people; lines end in a newline.
[[nodiscard]] std::string doctor_text(const HostReport& report,
                                      const std::vector<Finding>& findings);

/// The report for programs: one JSON object and a newline.
[[nodiscard]] std::string doctor_json(const HostReport& report,
                                      const std::vector<Finding>& findings);

/// `hapticd doctor`, its arguments beginning with "doctor". Prints the report, or what is wrong
/// with the command line; returns the exit code.
int run_doctor(int argc, const char* const* argv);

}  // namespace hapticd
