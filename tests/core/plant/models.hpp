// Small assembled models for the tests of plant and model file: a wheelset on driven or free rollers, alone or with machines.
#pragma once
#include "rollerrig/plant/model_file.hpp"
#include "rollerrig/simulate/driver.hpp"
#include "system/models.hpp"

namespace rollerrig::test {

/// Coarse profiles: a file of some 20 kB.
Parts small_parts(bool driven);

AssembledModel assembled(Parts const& parts, std::optional<MechatronicSetup> setup = {});

/// A braked axle with slide protection and a speed sensor that counts teeth.
AssembledModel braked();

}  // namespace rollerrig::test
