#!/bin/bash
# A Slurm cluster of this machine alone, for tests: one_node.sh FOLDER PORT PORT COMMAND ...
# Runs the command with the cluster, whose whole state is in the (empty) folder, and ends the cluster with it. As root, without systemd.
set -eu
folder=$1 controller_port=$2 node_port=$3
shift 3
host=$(hostname -s)
mkdir -p "$folder"/{state,spool}
head -c 1024 /dev/urandom > "$folder/munge.key"
chmod 400 "$folder/munge.key"
cat > "$folder/slurm.conf" <<END
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$controller_port
SlurmdPort=$node_port
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=1,bf_interval=1
ReturnToService=2
SlurmdParameters=config_overrides
NodeName=$host NodeAddr=127.0.0.1 CPUs=4 RealMemory=500 State=UNKNOWN
PartitionName=main Nodes=$host Default=YES MaxTime=INFINITE State=UP
END
export SLURM_CONF=$folder/slurm.conf

# Each in the foreground of a job of this shell, so that it is this shell that ends it.
munged --foreground --force --key-file="$folder/munge.key" --socket="$folder/munge.socket" \
    --pid-file="$folder/munged.pid" --log-file="$folder/munged.log" --seed-file="$folder/munged.seed" > "$folder/munged.out" 2>&1 &
daemons=$!
trap 'kill $daemons 2> /dev/null; wait' EXIT
for _ in $(seq 100); do [ -S "$folder/munge.socket" ] && break; sleep 0.1; done
slurmctld -D > "$folder/slurmctld.out" 2>&1 &
daemons="$! $daemons"
slurmd -D > "$folder/slurmd.out" 2>&1 &
daemons="$! $daemons"
for _ in $(seq 300); do
    if sinfo --noheader --format=%T 2> /dev/null | grep -q idle; then
        "$@"
        exit
    fi
    sleep 0.2
done
echo "the cluster does not come up" >&2
tail -n 20 "$folder"/*.out "$folder"/*.log >&2
exit 125
