# The executor `local`: a job is a process that make starts on this machine.
#
# What an executor is. Recipes of pipelines/ run a tool only behind $(call job,...), and a file of this folder says what
# that does. EXECUTOR=NAME takes executors/NAME.mk, EXECUTOR=folder/NAME.mk a file that lies elsewhere; without it this
# one is taken. It defines:
#
# $(call job,NAME,THREADS,INPUTS,OUTPUTS,LOG): the words in front of the tool's command. Nothing, or a program with its
#   options that takes the command as its last arguments.
#   NAME     begins with the stage, on which memory and time depend, and differs from every other job's of the same run:
#            spec, lift, simulate-support-stiff, screen0
#   THREADS  how many threads it will use, as a word of the shell
#   INPUTS   files and folders that it reads. The files of the bundle that a stage reads are named in its slice of the
#            run specification (spec/STAGE.json), with its folder
#   OUTPUTS  files that are there when it has ended well; it may make more beside them
#   LOG      a file for what it prints, if the executor needs one; its folder exists
# $(call job_threads,NAME): the threads that such a job should get, as a word of the shell. The recipe hands them to the
#   tool (--threads) and back to `job`.
# $(call before_run,RUN): if it has one, a command that make runs before it looks at the files of a run; what it prints ends make.
# EXECUTOR_VARIABLES, if it has any: the names of its own variables, which a user may then set on make's command line.
#
# What recipes count on. The arguments of the command arrive byte for byte, in this working folder and with this
# environment, which holds the keys of model servers. The program returns when the command has ended and its outputs can
# be read here, with the command's exit status: pm-screen's 6 is a verdict. What the command prints comes out as well,
# since a batch finds its reasons there. Make passes an interruption on, and the job ends with it. A job may be started
# again after a failure: tools write a file under another name and rename it.
#
# Not jobs, but make's own work: what it computes while it reads (`evaluate` checks its hashes so), the makes of a batch's
# scenes, and copies from BASE.

job =

# The cores are divided by make's -j, which MAKEFLAGS holds while recipes run.
CORES := $(shell nproc)
slots = $(or $(patsubst -j%,%,$(filter -j%,$(MAKEFLAGS))),1)
job_threads = $(or $(THREADS),$$(( $(CORES) / $(slots) > 0 ? $(CORES) / $(slots) : 1 )))
