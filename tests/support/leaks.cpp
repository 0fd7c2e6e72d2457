// What the leak sanitizer is told, in programs that are built with it. MPI and its friends leave
// memory behind at their end, by design of theirs. To know it as theirs, they must still be loaded
// then.
extern "C" {

const char* __lsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
  return "leak:libmpi.so\n"
         "leak:libopen-rte.so\n"
         "leak:libopen-pal.so\n"
         "leak:libpmix.so\n"
         "leak:mca_\n"  // Open MPI's modules, and those of PMIx
         "leak:libevent\n"
         "leak:libhwloc.so\n"
         "leak:libfabric.so\n"
         "leak:libucp.so\n"
         "leak:libucs.so\n"
         "leak:__vasprintf_internal\n";  // in Open MPI's asprintf; nothing of ours calls it
}

const char* __lsan_default_options() {  // NOLINT(bugprone-reserved-identifier)
  return "print_suppressions=0";
}

int dlclose(void* /*library*/) {
  return 0;
}

}  // extern "C"
