// What a ROS 2 node does with TipController, without ROS: 100 Hz updates towards a wanted tip, then what it would publish.
//
//     ros2_core robots/childs3.toml
#include "tip_controller.hpp"

#include <cstdio>

int main(int argc, char **argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: ros2_core robots/childs3.toml\n");
        return 2;
    }
    try {
        TipController controller(argv[1], TipController::Settings{});
        cppr::Vector wanted = controller.state().tip;
        wanted[1] += 3e-3;
        wanted[2] -= 4e-3;
        // Two motors cannot place all three coordinates: what a bent robot loses in length is left free.
        for (int cycle = 0; cycle < 200; ++cycle) {
            wanted[0] = controller.state().tip[0];
            if (!controller.update(wanted, 0.01)) {
                std::fprintf(stderr, "ros2_core: no stable equilibrium towards the wanted tip\n");
                return 1;
            }
        }
        const TipController::State &state = controller.state();
        for (std::size_t i = 0; i < controller.names().size(); ++i) {
            std::printf("%s: position %.4f mm, effort %.4f N\n", controller.names()[i].c_str(), 1e3 * controller.joints()[i],
                        state.tension[i]);
        }
        std::printf("tip: %.3f %.3f %.3f mm\n", 1e3 * state.tip[0], 1e3 * state.tip[1], 1e3 * state.tip[2]);
        const double y = state.tip[1] - wanted[1], z = state.tip[2] - wanted[2];
        return std::hypot(y, z) < 1e-5 ? 0 : 1;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "ros2_core: %s\n", error.what());
        return 1;
    }
}
