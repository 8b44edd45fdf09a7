#!/bin/sh
# Slurm on this machine alone, for tests: as root, without systemd, on the loopback interface.
#   farm/slurm/one-node.sh start FOLDER    everything is kept in FOLDER; then: export SLURM_CONF=FOLDER/slurm.conf
#   farm/slurm/one-node.sh stop FOLDER
set -eu
folder=$(cd "$2" && pwd)
conf=$folder/slurm.conf

# Ends the process of a pid file, and waits until it has ended.
stop_one() {
    [ -s "$1" ] || return 0
    pid=$(cat "$1")
    kill "$pid" 2>/dev/null || return 0
    for _ in $(seq 100); do
        kill -0 "$pid" 2>/dev/null || return 0
        sleep 0.1
    done
    kill -9 "$pid" 2>/dev/null || true
}

stop() {
    for daemon in slurmd slurmctld munged; do stop_one "$folder/$daemon.pid"; done
}

# Three ports that nobody listens on.
ports() {
    python3 -c '
import socket
taken = [socket.create_server(("127.0.0.1", 0)) for _ in range(2)]
print(*[s.getsockname()[1] for s in taken])'
}

start() {
    [ "$(id -u)" = 0 ] || { echo "one-node.sh: Slurm needs root here" >&2; exit 1; }
    mkdir -p "$folder/state" "$folder/spool"
    dd if=/dev/urandom of="$folder/key" bs=1024 count=1 2>/dev/null
    chmod 400 "$folder/key"
    chmod 755 "$folder"
    # shellcheck disable=SC2046 # two words
    set -- $(ports)
    host=$(hostname -s)
    cat >"$conf" <<CONF
ClusterName=one
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$1
SlurmdPort=$2
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
SlurmUser=root
SlurmdUser=root
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MailProg=/bin/true
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
KillWait=20
SchedulerParameters=sched_interval=2,bf_interval=2
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=1024 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=30 State=UP
CONF
    munged --key-file="$folder/key" --socket="$folder/munge.socket" --pid-file="$folder/munged.pid" \
        --log-file="$folder/munged.log" --seed-file="$folder/munge.seed" --force
    slurmctld -f "$conf"
    slurmd -f "$conf"
    export SLURM_CONF="$conf"
    for _ in $(seq 300); do
        case "$(sinfo -h -o %t 2>/dev/null)" in idle*) return 0 ;; esac
        sleep 0.2
    done
    echo "one-node.sh: the node does not become idle; see $folder/*.log" >&2
    stop
    exit 1
}

case $1 in
start) start ;;
stop) stop ;;
*) sed -n '2,4s/^# *//p' "$0" >&2; exit 2 ;;
esac
