// Redeploys the node furthest upstream that has stopped sending, and gives it five seconds to be back.
#include <iostream>
#include <string>
#include <utility>

int main() {
    const std::pair<std::string, std::string> pipeline[] = {{"rgb_camera", "camera"},
                                                            {"depth_camera", "depth"},
                                                            {"sensors_fused", "sensor_fusion"},
                                                            {"segmentation", "segmentation"}};
    std::string line;
    std::getline(std::cin, line);  // what the system is
    int wait = 0;                  // decisions until it looks again, one every 0.2 s
    while (std::getline(std::cin, line)) {
        std::string answer = "{}";
        if (wait > 0) {
            --wait;
        } else {
            for (const auto& [topic, node] : pipeline) {
                if (line.find("\"managed_subsystem_" + topic + "_freq\":0.0") != std::string::npos) {
                    answer = R"({"adaptations":[{"kind":"redeploy","node":")" + node + R"("}]})";
                    wait = 25;
                    break;
                }
            }
        }
        std::cout << answer << std::endl;
    }
}
