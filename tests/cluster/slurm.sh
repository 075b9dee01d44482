#!/bin/bash
# A private Slurm on this machine, for tests: an own munged on a socket, slurmctld, and a slurmd for each of some virtual nodes.
#
#   slurm.sh start FOLDER [NODES] [CPUS] [LINE...]   everything it writes is in FOLDER; prints nothing. LINE: more of slurm.conf
#   slurm.sh stop FOLDER                             ends what it started, jobs included
#   slurm.sh kill FOLDER DAEMON                      SIGKILL for one: slurmctld, or a node's slurmd with its tasks (n1)
#   slurm.sh revive FOLDER DAEMON                    starts it again
#
# Who uses it sets SLURM_CONF=FOLDER/slurm.conf. Debian has the programs: slurm-wlm, munge.
set -eu
export PATH=$PATH:/usr/sbin
action=$1 folder=$(realpath -m -- "$2")
shift 2
export SLURM_CONF=$folder/slurm.conf

free_ports() { # COUNT
  python3 - "$1" <<'PY'
import socket, sys
held = [socket.socket() for _ in range(int(sys.argv[1]))]
for s in held:
    s.bind(("127.0.0.1", 0))
print(*(s.getsockname()[1] for s in held))
PY
}

configure() { # NODES CPUS LINE...
  local nodes=$1 cpus=$2 ports node=0
  shift 2
  read -ra ports < <(free_ports $((nodes + 1)))
  mkdir -p "$folder"/{state,spool,log,pid}
  head -c 1024 /dev/urandom >"$folder/munge.key"
  chmod 400 "$folder/munge.key"
  {
    # What a container or a small virtual machine gives: no cgroups, no accounting, nodes that are smaller or wider than the machine.
    cat <<CONF
ClusterName=physmas-test
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=${ports[0]}
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
CredType=cred/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool/%n
SlurmctldPidFile=$folder/pid/slurmctld
SlurmdPidFile=$folder/pid/%n
SlurmctldLogFile=$folder/log/slurmctld
SlurmdLogFile=$folder/log/%n
SlurmctldDebug=info
SlurmdDebug=info
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=task=1
JobAcctGatherParams=OverMemoryKill
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SlurmdParameters=config_overrides
MpiDefault=none
SwitchType=switch/none
ReturnToService=2
SlurmdTimeout=10
SlurmctldTimeout=10
KillWait=2
MessageTimeout=10
MinJobAge=60
CommunicationParameters=NoAddrCache
SchedulerParameters=batch_sched_delay=0,sched_interval=1,bf_interval=1
CONF
    printf '%s\n' "$@"
    while [ $((node += 1)) -le "$nodes" ]; do
      echo "NodeName=n$node NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=${ports[node]} CPUs=$cpus RealMemory=4000 State=UNKNOWN"
    done
    echo "PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP"
  } >"$folder/slurm.conf"
  echo "CgroupPlugin=autodetect" >"$folder/cgroup.conf"
  seq -f n%g "$nodes" >"$folder/nodes"
}

alive() { [ -e "$folder/pid/$1" ] && kill -0 "$(<"$folder/pid/$1")" 2>/dev/null; }

start_munged() {
  munged --force --socket="$folder/munge.socket" --key-file="$folder/munge.key" --pid-file="$folder/pid/munged" \
    --log-file="$folder/log/munged" --seed-file="$folder/munge.seed" --num-threads=4 2>/dev/null
}
start_slurmctld() { slurmctld -f "$SLURM_CONF"; }
start_node() { slurmd -f "$SLURM_CONF" -N "$1"; }

# What a node runs: slurmstepd and its tasks are no children of slurmd, but have its node's name.
steps_of() { # NODE
  local environ
  for environ in $(grep -lzxF -e "SLURM_CONF=$SLURM_CONF" /proc/[0-9]*/environ 2>/dev/null); do
    if grep -zqxF -e "SLURMD_NODENAME=$1" "$environ" 2>/dev/null; then
      environ=${environ#/proc/}
      echo "${environ%/environ}"
    fi
  done
}

end() { # DAEMON SIGNAL
  local pid
  [ -e "$folder/pid/$1" ] || return 0
  pid=$(<"$folder/pid/$1")
  kill "-$2" "$pid" 2>/dev/null || return 0
  for _ in {1..100}; do
    if ! kill -0 "$pid" 2>/dev/null; then return 0; fi
    sleep 0.05
  done
  kill -KILL "$pid" 2>/dev/null || true
}

wait_for_nodes() {
  local count
  count=$(wc -l <"$folder/nodes")
  for _ in {1..300}; do
    if [ "$(sinfo -h -N -o '%N %T' 2>/dev/null | sort -u | grep -cE ' (idle|mixed|allocated)')" -eq "$count" ]; then return 0; fi
    sleep 0.1
  done
  echo "slurm.sh: not all nodes came up: see $folder/log" >&2
  return 1
}

case $action in
  start)
    configure "${1:-3}" "${2:-2}" "${@:3}"
    start_munged
    start_slurmctld
    while read -r node; do start_node "$node"; done <"$folder/nodes"
    wait_for_nodes
    ;;
  stop)
    if alive slurmctld; then scancel --user="$(id -un)" 2>/dev/null || true; fi
    while read -r node; do end "$node" TERM; done <"$folder/nodes"
    end slurmctld TERM
    while read -r node; do for pid in $(steps_of "$node"); do kill -KILL "$pid" 2>/dev/null || true; done; done <"$folder/nodes"
    end munged TERM
    ;;
  kill)
    end "$1" KILL
    if [ "$1" != slurmctld ]; then for pid in $(steps_of "$1"); do kill -KILL "$pid" 2>/dev/null || true; done; fi
    ;;
  revive)
    if alive "$1"; then exit 0; fi
    if [ "$1" = slurmctld ]; then start_slurmctld; else start_node "$1"; fi
    ;;
esac
