// Where does the train stop with a slide protection of my own?
//
//   rollerrig assemble adhesion_brake --external slide_protection --out brake.model
//   slide_protection brake.model
#include <cstdio>
#include <exception>
#include <string>

#include "model.hpp"

namespace {

constexpr double vent_slip = 0.2, fill_slip = 0.1;
enum Valve { fill, hold, vent };

int stop(std::string const& path) {
  rollerrig::Plant plant(rollerrig::read_model(model_bytes(path)));
  int const speed = index_of(plant, "train.speed"), distance = index_of(plant, "train.distance");
  int const valve[] = {index_of(plant, "wheelset_1.valve_command"), index_of(plant, "wheelset_2.valve_command")};
  int const axle_speed[] = {index_of(plant, "slide_protection.wheelset_1.axle_speed"),
                            index_of(plant, "slide_protection.wheelset_2.axle_speed")};
  constexpr double wheel_radius = 0.46;
  long vented = 0, step = 0;

  auto status = plant.start(plant.assembled().options.final_time);
  while (status == rollerrig::Status::ok && plant.time() < plant.assembled().options.final_time) {
    for (int i = 0; i < 2; ++i) {
      double const slip = 1.0 - wheel_radius * plant.get(axle_speed[i]) / plant.get(speed);
      int const command = slip > vent_slip ? vent : slip > fill_slip ? hold : fill;
      plant.set_input(valve[i], command);
      vented += command == vent;
    }
    status = plant.advance(static_cast<double>(++step) * plant.sampling_step());
  }
  std::printf("after %.3f s and %.2f m at %.2f km/h; cylinders vented in %ld of %ld samples\n%s\n", plant.time(),
              plant.get(distance), 3.6 * plant.get(speed), vented, 2 * step,
              std::string(status_sentence(status)).c_str());
  return status == rollerrig::Status::stopped ? 0 : 3;
}

}  // namespace

int main(int count, char** words) {
  try {
    if (count == 2) return stop(words[1]);
    std::fprintf(stderr, "slide_protection brake.model\n");
  } catch (std::exception const& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  return 2;
}
