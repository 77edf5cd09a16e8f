// Without exceptions a failure goes to jostle::on_error.
#include <jostle/jostle.hpp>

#include <cstdio>

int main() {
    jostle::on_error = [](jostle_status, const char *message) {
        std::puts(message);
        std::fflush(stdout);
        std::_Exit(0);
    };
    const jostle::context from;
    jostle::scene world(from);
    jostle::body_def def = jostle::disc(0.02);
    def.mass = -1;
    (void)world.add(def);
    return 1;
}
