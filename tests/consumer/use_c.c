/* A program outside of the repository, in C: found, linked and run. */
#include <jostle/jostle.h>

#include <stdio.h>

int main(void)
{
    if (jostle_abi_check(JOSTLE_ABI_VERSION) != JOSTLE_OK) {
        fprintf(stderr, "the header and the library do not match: %s\n", jostle_last_error());
        return 1;
    }
    if (jostle_abi_check(JOSTLE_ABI_VERSION + 1) == JOSTLE_OK) {
        fprintf(stderr, "the library accepts an ABI that it does not have\n");
        return 1;
    }
    puts(jostle_build_info());
    return 0;
}
