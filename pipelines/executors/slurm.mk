# The executor `slurm`: heavy jobs run on a cluster's nodes through srun, light ones where make runs (docs/cluster.md).
#
# Inside an allocation (salloc, sbatch) a job is a step of it; without one it is a Slurm job of its own. The folder, the tools and
# these files must have the same names on all nodes. Slurm's own variables (SLURM_PARTITION, SLURM_ACCOUNT, ...) count.
#
# RESOURCES  a file of lines `simulate: 8 cores, 2 GiB, 20 min` that win over resources.txt
# RETRY      memory, time or both: a job that was ended for too much of it is started once more with twice as much
# ARRAY      a number: one array job of that many workers takes all jobs, for sites that limit the number of jobs
# PATIENCE   seconds that files may take to be seen on another node, by default 60

EXECUTOR_VARIABLES := RESOURCES RETRY ARRAY PATIENCE
SLURM_FOLDER := $(PIPELINES)executors/

ifeq ($(MAKE_RESTARTS)$(DRY),)
  ifeq ($(shell command -v srun),)
    $(error EXECUTOR=slurm: srun is not on PATH: make has to run where Slurm's commands are)
  endif
endif
ifneq ($(filter-out memory time,$(RETRY)),)
  $(error RETRY=$(RETRY): expected memory, time, or both)
endif
ifneq ($(value RESOURCES),)
  ifeq ($(wildcard $(RESOURCES)),)
    $(error RESOURCES=$(call said,$(RESOURCES)) is not there)
  endif
endif

resource_files := $(SLURM_FOLDER)resources.txt $(RESOURCES)
# STAGE=CORES, or STAGE=here.
resource_words := $(shell source $(SLURM_FOLDER)resources.sh && all_resources $(resource_files) || printf 'refused %s' "$$complaint")
ifneq ($(filter refused,$(resource_words)),)
  $(error $(call said,$(wordlist 2,99,$(resource_words))))
endif

# What no node has is refused before anything runs. Workers of an array take all jobs, and only `evaluate` has references and results.
asked_stages := $(if $(filter-out 0,$(ARRAY)),worker,$(filter-out worker $(if $(filter evaluate%,$(MAKECMDGOALS)),,synth reference result),$(foreach w,$(resource_words),$(firstword $(subst =, ,$(w))))))
ifeq ($(MAKE_RESTARTS)$(DRY),)
  refusal := $(shell PM_RESOURCES='$(resource_files)' bash $(SLURM_FOLDER)slurm-limits.sh $(asked_stages))
  ifneq ($(refusal),)
    $(error $(call said,$(refusal)))
  endif
endif

# The stage of a job: simulate-support-stiff -> simulate, screen0 -> screen.
stage_of = $(patsubst %0,%,$(patsubst %1,%,$(patsubst %2,%,$(firstword $(subst -, ,$(1))))))
cores_of = $(patsubst $(stage_of)=%,%,$(or $(filter $(stage_of)=%,$(resource_words)),$(patsubst default=%,$(stage_of)=%,$(filter default=%,$(resource_words)))))

# Where make runs, its cores are divided as by the executor `local`.
CORES := $(shell nproc)
slots = $(or $(patsubst -j%,%,$(filter -j%,$(MAKEFLAGS))),1)
job_threads = $(or $(THREADS),$(filter-out here,$(cores_of)),$$(( $(CORES) / $(slots) > 0 ? $(CORES) / $(slots) : 1 )))

MAKE_PROCESS := $(shell echo $$PPID)
export PM_RESOURCES := $(resource_files)
export PM_RETRY := $(RETRY)
export PM_PATIENCE := $(or $(PATIENCE),60)
job = bash $(SLURM_FOLDER)slurm-job.sh $(1) $(call stage_of,$(1)) '$(3)' '$(4)' '$(5)' $(MAKE_PROCESS) --

ifeq ($(MAKE_RESTARTS)$(DRY),)
  watched := $(shell setsid bash $(SLURM_FOLDER)slurm-watch.sh $(MAKE_PROCESS) </dev/null >/dev/null 2>&1 &)
endif

# What the clocks of other machines did to the run, and what a make that was killed left running.
before_run = bash $(SLURM_FOLDER)slurm-before.sh $(1)

# The workers' queue, and the array job that empties it.
ifneq ($(filter-out 0,$(ARRAY)),)
  export PM_QUEUE := $(or $(BATCH),$(RUN),$(EVALUATE),.)/.queue
  ifeq ($(MAKE_RESTARTS)$(DRY),)
    workers := $(shell PM_RESOURCES='$(resource_files)' bash $(SLURM_FOLDER)slurm-workers.sh $(PM_QUEUE) $(ARRAY) $(MAKE_PROCESS) 2>&1 || printf ' refused')
    ifneq ($(filter refused,$(workers)),)
      $(error $(call said,$(filter-out refused,$(workers))))
    endif
  endif
endif
