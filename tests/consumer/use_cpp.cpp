// A program outside of the repository, in C++: found, linked and run.
#include <jostle/jostle.hpp>

#include <cstdio>

int main()
{
    if (jostle_abi_check(JOSTLE_ABI_VERSION) != JOSTLE_OK) {
        std::fprintf(stderr, "the header and the library do not match: %s\n", jostle_last_error());
        return 1;
    }
    std::puts(jostle_build_info());
    return 0;
}
