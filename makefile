# Pebble's build. `make` builds ./pebble, `make run` and `make test` also install what is missing,
# `make help` lists the rest. Needs GNU make 4; every setting can be given on the command line:
#
#   make CC=clang                another compiler (below the MPI wrapper), in an object folder of its own
#   make CFLAGS="-march=native"  added after the flags below
#   make DEBUG=1                 address and undefined-behaviour sanitizers: build/<compiler>-debug/pebble
#   make DEBUG=poison            memory whose content nobody may use is filled with a pattern: build/<compiler>-poison/pebble
#   make DEBUG=coverage          counts which lines run (make coverage): build/<compiler>-coverage/pebble
#   make PETSC_DIR=... PETSC_ARCH=...   another PETSc than the system's (3.18 or newer)
#   make PEBBLE=name BUILD=dir   other places for the program and the objects
#   make install PREFIX=dir DESTDIR=dir   where to install (default /usr/local); DESTDIR stands before it, for packages
#   make V=1                     show the commands

.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
SHELL := /bin/bash

# ---- Names. Objects of different compilers never mix. (Not taken from the environment: := .)
DEBUG    :=
compiler := $(if $(filter default,$(origin CC)),mpicc,$(notdir $(firstword $(CC))))
BUILD    := build/$(compiler)$(if $(DEBUG),-$(DEBUG:1=debug))
PEBBLE   := $(if $(DEBUG),$(BUILD)/pebble,pebble)
program  := $(if $(findstring /,$(PEBBLE)),$(PEBBLE),./$(PEBBLE))
python   := .venv/bin/python
sources  := $(wildcard src/*/*.c)
# Compiled once for each number of lanes (see src/base/lanes.h): the transfers, the laws that they call for many
# particles, and what measures the limit of a core.
kernels  := kernels/transfer_lanes kernels/transfer_sums kernels/fbar kernels/volume cost/chains
lanes    := $(kernels) $(patsubst src/%.c,%,$(wildcard src/physics/material_*.c))
objects  := $(patsubst src/%.c,$(BUILD)/%.o,$(filter-out $(kernels:%=src/%.c),$(sources)))
rooms    := $(patsubst src/%/,%,$(wildcard src/*/))
units    := $(patsubst tests/%.c,$(BUILD)/%,$(wildcard tests/unit_*.c tests/mpi_*.c tests/starter.c))
faults   := $(patsubst tests/%.c,$(BUILD)/%,$(wildcard tests/petsc/*.c))

# ---- PETSc, HDF5 and muParser through pkg-config. On a fresh machine this finds nothing;
# then `run` and `test` install it and start make again, which looks again.
PKG_CONFIG ?= pkg-config
ask        = $(shell $(PKG_CONFIG) $1 2>/dev/null)
first      = $(firstword $(foreach m,$1,$(if $(call ask,--modversion $m),$m)))
petsc.pc  := $(if $(PETSC_DIR),$(PETSC_DIR)/$(PETSC_ARCH)/lib/pkgconfig/petsc.pc,$(call first,petsc PETSc))
# A PETSc that was built with an HDF5 of its own must get that one, not the system's; one without HDF5 gets none.
petscconf := $(wildcard $(patsubst -I%,%/petscconf.h,$(call ask,--cflags-only-I $(petsc.pc))))
hdf5      := $(if $(petscconf),$(shell grep -s 'define PETSC_HAVE_HDF5 ' $(petscconf)),perhaps)
hdf5.own  := $(wildcard $(call ask,--variable=libdir $(petsc.pc))/libhdf5.so)
hdf5.pc   := $(if $(hdf5),$(if $(hdf5.own),,$(call first,hdf5-openmpi hdf5-mpich hdf5)))
modules   := $(petsc.pc) $(hdf5.pc) muparser
comma     := ,
# -isystem: warnings are for our code. rpath: a PETSc outside the system is found at run time too.
includes  := $(patsubst -I%,-isystem %,$(call ask,--cflags-only-I $(modules)))
# A PETSc that is a static library is taken by its path: a wrapper may look in the system's folders first.
petsc.lib := $(call ask,--variable=libdir $(petsc.pc))/libpetsc
petsc.a   := $(if $(wildcard $(petsc.lib).so),,$(wildcard $(petsc.lib).a))
libraries := $(call ask,$(if $(petsc.a),--static) --libs $(modules)) $(if $(hdf5.own),-lhdf5) -lm
libraries := $(if $(petsc.a),$(patsubst -lpetsc,$(petsc.a),$(libraries)),$(libraries))
rpath     := $(patsubst -L%,-Wl$(comma)-rpath$(comma)%,$(filter-out -L/usr/lib/%,$(call ask,--libs-only-L $(modules))))

# ---- The compiler: PETSc's own MPI wrapper; CC=clang is put below it, CC=mpi... takes its place.
petsc.cc := $(or $(call ask,--variable=ccompiler $(petsc.pc)),mpicc)
ifneq ($(filter mpi%,$(compiler)),)
  MPICC := $(if $(filter default,$(origin CC)),$(petsc.cc),$(CC))
else
  MPICC := $(petsc.cc)
  export OMPI_CC  := $(CC)
  export MPICH_CC := $(CC)
endif
MPIEXEC := $(or $(wildcard $(dir $(petsc.cc))mpiexec),mpiexec)

# ---- Flags. No fused multiply-adds that the compiler chooses by itself: a particle must get the
# same bits wherever it lies.
$(if $(filter-out 1 debug poison coverage,$(DEBUG)),$(error DEBUG=$(DEBUG) is none of 1, poison, coverage))
optimise          := -O3
optimise.1        := -O1 -fsanitize=address$(comma)undefined -fno-omit-frame-pointer
optimise.debug    := $(optimise.1)
optimise.poison   := -O3 -DMPM_POISON
optimise.coverage := -O1 -fno-inline-functions-called-once --coverage
optimise          := $(or $(optimise.$(DEBUG)),$(optimise))
# Debuggers see functions and lines; with local variables too (CFLAGS=-g) the build takes half as long again.
symbols  := $(if $(filter 1 debug,$(DEBUG)),-g,-g1)
flags    := -std=gnu11 $(optimise) $(symbols) -ffp-contract=off -Wall -Wextra -Wshadow -Wmissing-prototypes -fno-math-errno \
            -Isrc $(CFLAGS)
compile   = $(MPICC) $(flags) $(includes) -MMD -MP

# ---- Lanes: 8 with AVX-512, 4 with AVX2, 2 with what every processor has; the program picks at its start.
width.8  := -mavx512f -mavx512dq -mavx512vl -mavx512bw -mavx2 -mfma
width.4  := -mavx2 -mfma
# What most unit tests compute themselves takes less time than compilers need to optimise it.
unit.flags := $(if $(DEBUG),,-O1)
$(BUILD)/unit_transfer: unit.flags :=
# The serial program is compiled like the rest.
seed.flags := -O3 -ffp-contract=off
# What the bare kernels of `make bench` get besides.
bare.flags := -O3 -ffp-contract=fast
widths   := $(if $(filter x86_64%,$(shell $(MPICC) -dumpmachine 2>/dev/null)),8 4) 2
objects  += $(foreach w,$(widths),$(lanes:%=$(BUILD)/%.$w.o))
link      = $(MPICC) $(flags) $(LDFLAGS)

# ---- Open MPI refuses root and more ranks than cores, binds the ranks of two runs to the same cores,
# lets waiting ranks spin, and complains in containers that forbid reading another process's memory.
# Tests run there, on few cores: allow it, leave the ranks unbound, let them yield, copy twice.
# (PRTE_ is Open MPI 5's name. Only commands started by make see these.)
export OMPI_ALLOW_RUN_AS_ROOT := 1
export OMPI_ALLOW_RUN_AS_ROOT_CONFIRM := 1
export OMPI_MCA_rmaps_base_oversubscribe := 1
export PRTE_MCA_rmaps_default_mapping_policy := :oversubscribe
export OMPI_MCA_hwloc_base_binding_policy := none
export OMPI_MCA_mpi_yield_when_idle := 1
export OMPI_MCA_btl_vader_single_copy_mechanism := none
export OMPI_MCA_btl_base_warn_component_unused := 0
# With sanitizers: MPI's own leaks would drown ours.
export ASAN_OPTIONS := detect_leaks=0

# matplotlib's list of fonts, which would go to the user's home folder.
export MPLCONFIGDIR := $(CURDIR)/.venv/matplotlib

# ---- What a user asks for
.PHONY: all run test test-long test-widths test-petsc verify robust debug coverage fuzz bench paper studies calibrate simulate scaling report \
  format scenes install uninstall clean distclean help objects picture ctest pages FORCE

again = $(MAKE) --no-print-directory $(if $(findstring jobserver,$(MAKEFLAGS)),,-j$(shell nproc))

all: $(PEBBLE) ## the program (default)

run: ## install what is missing, build, run options/disks.opts, draw output/disks.png
	@tools/install.sh run
	+@$(again) picture

test: ## install what is missing, build, run every test but the long ones: seven minutes on two cores
	@tools/install.sh test
	+@$(again) ctest select="-LE 'long|extra'" after='$(python) tests/messages.py . $(BUILD)/tests/runs/said'

test-long: ## the long tests: all combinations, both compilers, vectors of 4 and of 2 particles, verify and robust
	@tools/install.sh test
	@tools/install.sh viewers || true # without ParaView its test fails, and says so
	+@$(again) ctest select="-L long"

verify: ## of the long tests those of accuracy: prints errors and orders beside those expected, and renews docs/trust.md
	@tools/install.sh test
	+@$(again) ctest select="-L verify -V"; status=$$?; \
	$(python) tools/trust/trust.py --take $(BUILD)/tests/runs/trust_all/trust.csv && exit $$status

robust: ## of the long tests those of robustness, on up to 32 processes: prints a line of figures for each matter
	@tools/install.sh test
	+@$(again) ctest select="-L robust"; status=$$?; \
	sed -n 's/^\(ok *\)\?figures */  /p' $(BUILD)/tests/Testing/Temporary/LastTest.log; exit $$status

test-widths: ## the tests that repeat others with vectors of 4 and of 2 particles, the shorter of which are long tests too
	@tools/install.sh test
	+@$(again) ctest select="-L widths"

# Everything of it is in a folder of its own, so that no object is ever linked with another PETSc.
another = $(CURDIR)/build/petsc
test-petsc: ## build PETSc 3.26 and pebble with it, run tests of warnings, bits, files and options; PETSC_SRC=folder: another source
	@env -u PETSC_DIR -u PETSC_ARCH tools/install.sh petsc
	@PETSC_SRC='$(PETSC_SRC)' tools/petsc.sh mpi
	+@$(again) ctest PETSC_DIR=$(another)/petsc PETSC_ARCH=opt BUILD=build/petsc/objects PEBBLE=build/petsc/pebble \
	  select="-L 'build|equal|parallel|options|output' -LE 'long|extra'"

# The harnesses are linked with libFuzzer; the objects, of clang, count what inputs reach.
fuzzer = $(again) CC=clang DEBUG=1 BUILD=build/fuzz PEBBLE=build/fuzz/pebble CFLAGS="$(CFLAGS) -fsanitize=fuzzer-no-link"
fuzz: ## random options (FUZZ=100000 inputs) and model files (a tenth) with sanitizers: no crash, hang or leak; 15 minutes
	@tools/install.sh fuzz
	+@$(fuzzer) build/fuzz/fuzz_options build/fuzz/fuzz_model
	@$(python) tests/fuzz.py build/fuzz . $(or $(FUZZ),100000)

debug: ## look for defects: sanitizers, floating-point traps, poisoned memory, and valgrind where it is installed; 10 minutes
	@tools/install.sh test
	+@$(again) ctest select="-L debug"

coverage: ## which lines of src the tests of `make test` reach, by rooms; COVERAGE=missing lists the others; 10 minutes
	@tools/install.sh test
	@find build/$(compiler)-coverage -name '*.gcda' -delete 2>/dev/null || true
	+@$(again) DEBUG=coverage ctest select="-LE 'long|extra' -E 'recipes|warnings|rooms'"
	@$(python) tools/coverage.py build/$(compiler)-coverage --least 92 $(if $(COVERAGE),--missing)

bare := $(widths:%=$(BUILD)/bare_%)
peers := build/bench-venv
bench: ## time this program, its bare kernels and others on the same work; BENCH=short: 3 minutes
	@tools/install.sh run
	-@$(if $(filter short,$(BENCH)),,{ test -d $(peers) || $(python) -m venv $(peers); } && \
	  grep == tools/requirements-bench.txt | xargs -n 1 $(peers)/bin/pip install -q --disable-pip-version-check)
	+@$(again) $(PEBBLE) build/seed_serial $(bare)
	@$(python) tools/bench.py --pebble $(program) --mpiexec $(MPIEXEC) --bare $(BUILD)/bare \
	  --flags="$(strip $(flags)); of the bare kernels also $(bare.flags); of seed_serial $(notdir $(CC)) $(seed.flags)" \
	  $(if $(filter short,$(BENCH)),--short,$(BENCH))

paper: ## run the studies of docs/paper.md, renew its tables and figures
	@tools/install.sh run
	+@$(again) $(PEBBLE) $(BUILD)/quadrature
	@$(python) tools/paper/paper.py --pebble $(program) --quadrature $(BUILD)/quadrature

studies: ## tables and figure of docs/choosing.md and docs/choosing-data.md anew from docs/data; STUDIES=missing: measure first what they lack; =all: all anew, 45 minutes
	@tools/install.sh run
	+@$(if $(STUDIES),$(again) $(PEBBLE))
	@$(python) tools/studies/studies.py --pebble $(program) $(if $(STUDIES),--measure $(STUDIES))

calibrate: ## measure the constants of the cost model for SCENE=options/x.opts on NP=2 processes; CALIBRATE="-model_file x": more options
	$(if $(SCENE),,$(error make calibrate needs a scene: make calibrate SCENE=options/disks.opts [NP=2]))
	@tools/install.sh run
	+@$(again) $(BUILD)/calibrate
	$(MPIEXEC) -n $(or $(NP),2) $(BUILD)/calibrate -options_file $(SCENE) $(CALIBRATE)

# The program in SimGrid's SMPI. Its build is separate: another compiler wrapper, a static PETSc.
simulator = build/simulate/pebble
simulate: ## run on simulated clusters (docs/cluster.md), hours; builds a PETSc first, once; SIMULATE="--only strong": a part
	@tools/install.sh simulate
	@PETSC_SRC='$(PETSC_SRC)' tools/petsc.sh simulate
	+@$(again) $(PEBBLE) $(BUILD)/calibrate
	+@$(again) $(simulator) PEBBLE=$(simulator) BUILD=build/simulate/objects DEBUG= \
	  PETSC_DIR=$(CURDIR)/build/simulate/petsc PETSC_ARCH=smpi CFLAGS="$(CFLAGS) -DMPM_SIMULATE -DSMPI_NO_OVERRIDE_MALLOC"
	@$(python) tools/simulate/simulate.py --pebble $(program) --calibrator $(BUILD)/calibrate --simulator $(simulator) \
	  --mpiexec $(MPIEXEC) $(SIMULATE)

scaling: ## how it scales: 1 to 32 processes, counted and predicted (docs/data/scaling); SCALING=full: longer
	@tools/install.sh run
	+@$(again) $(PEBBLE) $(BUILD)/calibrate
	@$(python) tools/scaling/scaling.py --pebble $(program) --calibrator $(BUILD)/calibrate --mpiexec $(MPIEXEC) $(if $(filter full,$(SCALING)),--full,$(SCALING))

report: ## docs/report.md, model.md, performance.md and figures anew from docs/data; REPORT=all: all data first
	@tools/install.sh run
	+@$(if $(filter all,$(REPORT)),$(again) scaling && $(again) simulate SIMULATE=--calibrate && )$(again) pages

format: ## clang-format on the C sources
	clang-format -i $(wildcard src/*/*.[ch] examples/*.c tests/*.[ch] tests/*/*.[ch] tools/*/*.[ch])

scenes: $(PEBBLE) ## run every scene of options/, draw docs/scene-*.png as its comment says
	@for scene in options/*.opts; do name=$$(basename $$scene .opts); echo "  $$name"; \
	  $(program) -options_file $$scene >output/$$name.log || { cat output/$$name.log; exit 1; }; \
	  $$(sed -n 's/^# *\(.venv.*plot.py.*\)/\1/p' $$scene) --small --out docs/scene-$$name.png || exit 1; done

place = PREFIX='$(PREFIX)' DESTDIR='$(DESTDIR)'
install: $(PEBBLE) ## copy program, scenes, tools that draw and documents to PREFIX (/usr/local)
	@$(place) tools/package.sh install $(program)

uninstall: ## remove what make install copied to PREFIX
	@$(place) tools/package.sh uninstall

clean: ## remove the program and all objects
	rm -rf $(PEBBLE) $(filter-out build/simulate build/petsc,$(wildcard build/*)) build/simulate/objects $(simulator) \
	  build/petsc/objects build/petsc/pebble

distclean: clean ## also remove .venv, the PETScs that were built and the products in output/
	rm -rf .venv build
	find output -mindepth 1 ! -name README.md -delete

help: ## this list
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  \1\t\2/p' $(firstword $(MAKEFILE_LIST)) | expand -t 14

# ---- Second halves of run, test and report, when everything is installed
picture: $(PEBBLE)
	$(program) -options_file options/disks.opts
	@$(python) tools/plot.py output/disks.h5 --out output/disks.png
	@printf '%s\n' "" "Products:" "  output/disks.png   the picture" \
	  "  output/disks.xdmf  for ParaView (its data: output/disks.h5)" "  output/disks.csv   history of energies and momentum"

ctest: $(PEBBLE) $(units) $(faults) $(BUILD)/rank $(BUILD)/calibrate $(BUILD)/quadrature build/seed_serial
	@rm -rf $(BUILD)/tests/runs
	@cmake -S tests -B $(BUILD)/tests -DSOURCE=$(CURDIR) -DBUILD=$(abspath $(BUILD)) -DPEBBLE=$(abspath $(PEBBLE)) \
	  -DPYTHON=$(abspath $(python)) -DMPIEXEC=$(MPIEXEC) >$(BUILD)/cmake.log 2>&1 || { cat $(BUILD)/cmake.log; exit 1; }
	@cd $(BUILD)/tests && ctest -j3 --output-on-failure --no-tests=error $(select)
	@$(after)

pages: $(PEBBLE)
	@$(python) tools/report/constants.py $(program)
	@$(python) tools/report/report.py

# ---- Building. A line a file; V=1 shows the commands.
say = $(if $(V),,@printf '  %-5s %s\n' $1 $@;)
# Of objects also how many of all are there.
count = $(if $(V),,@printf '  %-5s [%d/%d] %s\n' CC "$$(ls $(objects) 2>/dev/null | wc -l)" $(words $(objects)) $@;)
# What the compiler says is also kept beside the object: tests/test_warnings.py wants it to be nothing.
keep = 2>$@.said; status=$$?; cat $@.said >&2; exit $$status

objects: $(objects) $(BUILD)/calibrate

# A copy, so that ./pebble is always the one of the last make, whatever its compiler.
ifneq ($(PEBBLE),$(BUILD)/pebble)
$(PEBBLE): $(BUILD)/pebble FORCE
	@cmp -s $< $@ || cp -f $< $@
endif

$(BUILD)/pebble: $(objects)
	$(call say,LINK) $(link) -o $@ $^ $(rpath) $(libraries)

# Of the archive a program is linked with what it needs. (It holds the names of the objects only.)
$(BUILD)/pebble.a: $(filter-out $(BUILD)/run/main.o,$(objects))
	$(call say,AR) rm -f $@ && $(AR) qcsT $@ $^

$(units): $(BUILD)/%: tests/%.c $(BUILD)/pebble.a
	$(call say,UNIT) $(compile) $(unit.flags) -o $@ $< $(BUILD)/pebble.a $(rpath) $(libraries)

# It starts as quickly as it can only without PETSc.
$(BUILD)/rank: tests/rank.c $(BUILD)/flags
	$(call say,CC) $(CC) -std=gnu11 -O1 -Wall -Wextra -o $@ $<

# Programs that show faults of PETSc: nothing of Pebble is in them.
$(faults): $(BUILD)/%: tests/%.c $(BUILD)/flags | $(BUILD)/petsc
	$(call say,FAULT) $(MPICC) -std=gnu11 -O2 -Wall -Wextra $(includes) -o $@ $< $(rpath) $(libraries)

$(BUILD)/fuzz_%: tests/fuzz_%.c $(filter-out $(BUILD)/run/main.o,$(objects))
	$(call say,FUZZ) $(filter-out -MMD -MP,$(compile)) -fsanitize=fuzzer -o $@ $(filter %.c %.o,$^) $(rpath) $(libraries)

$(BUILD)/quadrature: tools/paper/quadrature.c $(BUILD)/flags
	$(call say,TOOL) $(compile) -o $@ $< $(rpath) $(libraries)

$(BUILD)/calibrate: $(wildcard tools/calibrate/*.[ch]) $(filter-out $(BUILD)/run/main.o,$(objects))
	$(call say,TOOL) $(filter-out -MMD -MP,$(compile)) -o $@ $(filter %.c %.o,$^) $(rpath) $(libraries)

$(BUILD)/%.o: src/%.c $(BUILD)/flags | $(rooms:%=$(BUILD)/%)
	$(count) $(compile) $(defines) -c -o $@ $< $(keep)

define with_lanes
$(BUILD)/%.$1.o: src/%.c $(BUILD)/flags | $(rooms:%=$(BUILD)/%)
	$$(count) $$(compile) -DMPM_WIDTH=$1 $(width.$1) -c -o $$@ $$< $$(keep)
endef
$(foreach w,$(widths),$(eval $(call with_lanes,$w)))

# The plain serial program of the assignment, which the tests compare with: no PETSc, no MPI.
build/seed_serial: examples/seed_serial.c makefile | $(BUILD)
	$(call say,CC) $(CC) $(seed.flags) -o $@ $< -lm

# The bare kernels, with which `make bench` compares a step: PETSc's types, but nothing that it computes.
$(bare): $(BUILD)/bare_%: tools/bench/bare.c $(BUILD)/flags
	$(call say,CC) $(compile) $(bare.flags) -DMPM_WIDTH=$* $(width.$*) -o $@ $< -lm

# Other flags, another PETSc: everything is compiled anew. (Files are rewritten only when they change.)
replace = cmp -s $@.new $@ && rm $@.new || mv $@.new $@
$(BUILD)/flags: FORCE | $(BUILD)
	$(if $(call ask,--modversion $(modules)),,$(error PETSc, HDF5 or muParser not found by pkg-config; "make run" installs what is missing))
	$(file >$@.new,$(OMPI_CC) $(compile) $(width.8) $(width.4) $(rpath) $(libraries))@$(replace)

# Only version.o knows the commit, so that a commit recompiles one file.
$(BUILD)/base/version.o: defines = @$(BUILD)/version
$(BUILD)/base/version.o: $(BUILD)/version
$(BUILD)/version: FORCE | $(BUILD)
	@{ echo "'-DMPM_GIT=\"$$(git --git-dir=.git describe --always --dirty 2>/dev/null || echo unknown)\"'"; \
	   echo "'-DMPM_COMPILER=\"$$($(MPICC) --version | head -n 1)\"'"; \
	   echo "'-DMPM_CFLAGS=\"$(strip $(flags))\"'"; } >$@.new; $(replace)

$(BUILD) $(BUILD)/petsc $(rooms:%=$(BUILD)/%):
	@mkdir -p $@

-include $(objects:.o=.d) $(units:=.d) $(BUILD)/quadrature.d $(bare:=.d)
