// Compiled into the tests of the preset asan: the build in which broken contracts must stop the program.
#ifdef NDEBUG
#error "NDEBUG is defined: this build would run the tests without assertions"
#endif
