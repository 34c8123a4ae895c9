// See arm_model.h. That a hand holding a handle is well described by one mass, spring and damper at
// these frequencies, and that grip raises stiffness and damping together, is common to the
// literature on hand impedance; the very numbers here are guesses within its range. The band of
// physiological tremor is that of McAuley and Marsden, "Physiological and pathological tremors and
// rhythmic central motor control", Brain 123, 2000.
#include "device/simulated/arm_model.h"

namespace hapticd {
namespace {

constexpr ArmModel kOff{.source = "by definition"};

constexpr ArmModel kLight{.mass = 0.1,
                          .stiffness = 400.0,
                          .damping = 10.0,
                          .inertia = 1e-4,
                          .rotational_stiffness = 2.0,
                          .rotational_damping = 0.02,
                          .tremor = 5e-5,
                          .source = "guess; tremor band 8-12 Hz: McAuley and Marsden 2000"};

constexpr ArmModel kFirm{.mass = 0.3,
                         .stiffness = 1500.0,
                         .damping = 35.0,
                         .inertia = 3e-4,
                         .rotational_stiffness = 6.0,
                         .rotational_damping = 0.06,
                         .tremor = 1e-4,
                         .source = "guess; tremor band 8-12 Hz: McAuley and Marsden 2000"};

// No person reacts so fast: the delay of a stretch reflex is some tens of milliseconds. Without any
// delay the arm is in phase with every string.
constexpr ArmModel kAdversarial{.mass = 0.1,
                                .stiffness = 400.0,
                                .damping = 2.0,
                                .inertia = 1e-4,
                                .rotational_stiffness = 2.0,
                                .rotational_damping = 0.01,
                                .delay = 0.0,
                                .source = "guess: the worst case, not a person"};

constexpr ArmModels kUsual{kOff, kLight, kFirm, kAdversarial};

}  // namespace

const ArmModels& usual_arms() noexcept { return kUsual; }

}  // namespace hapticd
